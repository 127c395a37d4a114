"""What delimited text needs before its numbers can be taken: encoding, layout, stamps of time, lines above a table.

Nothing here knows of channels or units beyond their names.
"""
