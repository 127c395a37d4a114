"""Coupling schemes: one macro step of several participants, parallel, sequential, implicit or iterated.

State in, state out.
Participants are FMUs or anything that steps like one.
"""
