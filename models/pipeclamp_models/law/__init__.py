"""A law: effects put together, their parameters' values, the file they are kept in, and the range they hold for.

A user's own effects, which are data and never run, are read here too.
The force that a law gives is computed in `realise`.
"""
