"""A virtual test rig: campaigns of a law whose truth is known, to ask what a test plan would see.

What is run and how well it is measured (`plan`), what the clamp obeys (`truth`), and the records (`runs`).
"""
