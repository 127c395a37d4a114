"""Realisations: the equations as arrays, as plain Python, as mathematics to read."""
