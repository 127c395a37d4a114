"""Co-simulation from a system's file to a result that says whether it can be trusted.

Energy, step error, hidden motion and divergence are watched.
The result is a table with names and units.
"""
