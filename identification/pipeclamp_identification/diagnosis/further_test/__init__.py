"""The test that would tell rivals apart: what each foretells of a motion, within what the rig can do.

A test is proposed here, and drawn nowhere else.
What the rig can do is stated here for all who plan tests.
"""
