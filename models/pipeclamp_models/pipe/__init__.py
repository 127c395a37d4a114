"""The pipe: section, materials, beam, modes, what is cut off, stability, and one step in time.

From a description in TOML to the modal matrices that FMUs, co-simulation and harmonic balance share.
Clamps enter as forces at their places.
"""
