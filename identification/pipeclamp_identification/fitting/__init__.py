"""Fits: a law's parameters from loops, with their uncertainty, and its error on conditions that were left out.

All runs at once by least squares, or by the paper's own route over surfaces.
The parameter file is made of what comes out.
"""
