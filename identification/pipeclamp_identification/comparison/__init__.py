"""A law against tests: how much it errs, and where.

The squared error is broken down so that the parts add up to the whole, each beside its scatter.
Sentences say where to look first.
"""
