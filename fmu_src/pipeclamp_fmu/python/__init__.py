"""Python FMUs: contents packed by pythonfmu.

Modules are named by their equations, so that different laws live in one process.
The native kind stands in the room beside this one.
"""
