"""Equations to be read by people: plain text for terminals, reports and FMUs, LaTeX for pages.

Both are printed from the same statement as all other realisations; nothing is computed with them.
"""
