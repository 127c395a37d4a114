"""The programs inside Python FMUs: standard library only, put together into one module each.

They are imported here for tests; in an FMU they stand alone.
Stand-ins take the place of what the build fills in.
"""
