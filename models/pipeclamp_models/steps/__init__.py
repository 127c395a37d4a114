"""A clamp's way from one point in time to the next: its turns, the parts that it is walked in, A and f of it.

On the standard library alone, but for `ways`, which is for many samples at once: the clamp's Python FMU inlines these
modules, records are walked by them, and the native FMU's C has counterparts.
"""
