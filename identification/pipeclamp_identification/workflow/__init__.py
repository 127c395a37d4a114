"""What people do with tests, whatever their kind: read, identify, compare, diagnose, add and remove effects, climb.

The one room that knows both kinds of campaign, of records and of metrics alone.
Commands and the Python API call it.
"""
