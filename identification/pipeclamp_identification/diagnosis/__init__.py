"""Which effect a law lacks: noise, candidates, evidence, verdict, and the test that would tell.

A verdict is made here and nowhere else.
Campaigns of metrics alone have a room of their own.
"""
