"""What every room stands on: errors, files that appear whole, TOML, tables, units, arrays.

Nothing here knows what a clamp is.
It imports nothing of the project.
"""
