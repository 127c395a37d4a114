"""Which tests to run: the loop test that makes a pipe's response surer, and a campaign before any test.

Both ask what tests not yet run would tell, by a law's exact derivatives.
"""
