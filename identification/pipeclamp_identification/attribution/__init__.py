"""The pipe or the clamp? Which parameter of a coupled model is wrong, or which measurement would tell.

Each suspect is refitted alone and all together, in units of the measurement's noise.
The verdict is made here.
"""
