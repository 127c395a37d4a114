"""Loops: the mean cycle of each run with its scatter, its metrics, and what it is made of.

From records to harmonics of displacement and force.
The published rows of a paper are read here as well.
"""
