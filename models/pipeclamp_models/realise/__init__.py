"""Realisations of a law's equations: arrays with exact derivatives, plain Python, C, mathematics to read.

All are derived from the one statement in `effects`; one test holds them together.
The force along given motions is computed here too.
"""
