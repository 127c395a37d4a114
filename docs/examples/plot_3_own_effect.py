"""
An effect of your own
=====================

A notch that the clamp is held in is in no catalogue. A declaration in TOML states its force; from there on
it is identified, diagnosed and built as every other effect.
"""

# %%
# The declaration: a name, what it looks like, its force and energy as expressions, its parameters with units, starts
# and bounds. Expressions are parsed, never run.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pipeclamp as pc

folder = Path(tempfile.mkdtemp())
clamp = pc.identify(pc.read_campaign("clamp_a"))
notch = folder / "notch.toml"
notch.write_text(
    """
id = "notch"
title = "A notch that the clamp is held in"
looks_like = "a wiggle in both branches of the loop, at one displacement, whatever the amplitude"
told_apart_by = "small cycles in the notch, and beside it"
force = "k_b * (y - y_b) * exp(-((y - y_b) / 0.1)**2)"
energy = "k_b * 0.005 * (1 - exp(-((y - y_b) / 0.1)**2))"
[[parameters]]
symbol = "k_b"
unit = "N/mm"
meaning = "stiffness in the notch, which is 0.1 mm wide"
start = "0.2 * F_typical / A_typical"
lower = 0
[[parameters]]
symbol = "y_b"
unit = "mm"
meaning = "displacement of the notch"
start = ["-0.5 * A_highest", "-0.2 * A_highest", "0.2 * A_highest", "0.5 * A_highest"]
lower = "-A_highest"
upper = "A_highest"
"""
)

# %%
# The virtual rig tests a clamp that has such a notch, of 400 N/mm at 0.35 mm.

rig = pc.rig(
    clamp,
    folder / "notched",
    effects=notch,
    values={"k_b": 400.0, "y_b": 0.35},
    amplitudes=[0.3, 0.65, 1.0],
    frequencies=[1.0, 4.0],
    temperatures=[20.0, 250.0],
    cycles=3,
    rate=300.0,
)
tests = rig.tests()

# %%
# Fitted with and without it:

bare = pc.identify(tests)
with_notch = pc.identify(tests, effects=[notch])
for law in (bare, with_notch):
    print(law)
with_notch.to_frame().select("parameter", "value", "standard_error", "unit")[-2:]

# %%
# What the notch adds to a loop of 1 mm at 1 Hz: the difference of the two laws' forces.

angle = np.linspace(0, 2 * np.pi, 400)
y, v = np.sin(angle), 2 * np.pi * np.cos(angle)
figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
for law, label, colour in (
    (bare, "base law", "#8a99a8"),
    (with_notch, "with the notch", "#2b7bba"),
):
    axes.plot(y, law.force(y, v, A=1.0, f=1.0, T=20.0), color=colour, label=label)
axes.axvline(
    with_notch.values["y_b"],
    color="#c2452d",
    linewidth=0.8,
    linestyle="--",
    label="the notch",
)
axes.set(xlabel="y / mm", ylabel="F / N")
axes.legend(frameon=False)
axes.grid(alpha=0.3)
