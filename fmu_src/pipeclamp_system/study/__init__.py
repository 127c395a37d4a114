"""A system over thousands of cases: what is varied, one case, all cases on all cores or a cluster.

Finished cases are kept in a journal, so that a run goes on where it was stopped.
A case is a co-simulation or a steady state.
"""
