"""Signals by themselves: harmonics over whole cycles, reversals, levels of quantisation.

Arrays in, arrays out.
What a run or a clamp is isn't known here.
"""
