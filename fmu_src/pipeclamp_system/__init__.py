"""Runs systems: pipe and clamps coupled in time, in steady states, and in studies of thousands of cases.

It knows no test data and uses nothing of identification.
Its packages, each importing only those before it: description, fmus, coupling, transient, cosim, steady, response,
bands, study.
"""
