"""An effect that nobody has: stiffness that rises and falls again over frequency, by declaration."""

BUMP = """
id = "bump"
title = "A fixture that is stiffer near one frequency"
looks_like = "stiffness that rises and falls again over f"
scales = [{ coefficient = "stiffness", factor = "1 + s_b * exp(-((f - 2.7) / 0.7)**2)" }]
[[parameters]]
symbol = "s_b"
unit = "-"
meaning = "share by which it is stiffer"
start = 0.01
"""
