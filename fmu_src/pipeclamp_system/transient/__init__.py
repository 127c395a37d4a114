"""Pipe and clamps as one set of equations, integrated in time without FMUs.

What co-simulations and steady states are held against, and what records measured on a pipe are compared with.
The laws' own memory is part of the state.
"""
