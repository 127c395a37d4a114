"""Makes FMUs: clamp, pipe and excitation, in Python and in C, and SSPs of them.

It knows no test data and runs nothing but what a finished FMU must give.
Its packages, each importing only those before it: slaves, describe, contents, python, native.
"""
