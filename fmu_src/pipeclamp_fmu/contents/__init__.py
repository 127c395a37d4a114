"""What goes into an FMU, whatever its kind: variables, values, documentation, reference results.

A law that could create energy is refused here.
Packing is left to `python` and `native`.
"""
