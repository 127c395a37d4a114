"""Which channel of a file is what: by its name and unit, or as it was stated; else the question that a user answers.

Tables whose channels are known become samples in our units.
"""
