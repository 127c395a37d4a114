"""Realisations: the equations as arrays, as plain Python, as C, as mathematics to read."""
