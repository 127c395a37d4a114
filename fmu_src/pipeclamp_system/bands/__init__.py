"""How sure a simulation is: what a law's uncertainty does to the pipe's response and to a run in time.

Steady states by their exact derivatives, runs in time by an ensemble.
Parameters, scatter from run to run and the law's form are told apart.
"""
