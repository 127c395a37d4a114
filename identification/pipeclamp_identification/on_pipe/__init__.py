"""What was measured on the pipe, held against pipe and clamps: sines and records of any motion, at probes.

The model's side comes from `pipeclamp_system`.
Which parameter is wrong is asked in the room beside this one.
"""
