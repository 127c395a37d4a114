"""FMUs as participants: loaded, stepped, saved and restored, their messages collected, their variables found.

The one room that calls fmpy to run an FMU.
What they are coupled to is decided elsewhere.
"""
