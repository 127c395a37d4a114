"""Steady states by harmonic balance: clamps' harmonics, branches and their stability, frequency response, dots on it.

Nothing is integrated but the dots and the small disturbances.
Branches that nothing joins to the others are sought too.
"""
