"""Native FMUs: C from the same equations, compiled and packed for FMI 2.0 and 3.0.

The C that doesn't depend on the law stands in `c`.
Nothing of Python is left in what it makes.
"""
