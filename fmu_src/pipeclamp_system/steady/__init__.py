"""Steady states by harmonic balance: clamps' harmonics, branches and their stability.

Nothing is integrated but what doesn't repeat, and the small disturbances.
Branches that nothing joins to the others are sought too.
"""
