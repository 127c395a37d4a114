"""
An effect of your own
=====================

A bracket that the clamp touches on one side is in no catalogue. A declaration in TOML states its force; from there on
it is identified, diagnosed and built as every other effect.
"""

# %%
# The declaration: a name, what it looks like, its force and energy as expressions, its parameters with units, starts
# and bounds. Expressions are parsed, never run.

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pipeclamp as pc

folder = Path(tempfile.mkdtemp())
pc.identify(pc.read_campaign("clamp_a")).save(folder / "clamp.json")
bracket = folder / "bracket.toml"
bracket.write_text(
    """
id = "bracket"
title = "A bracket that the clamp touches on one side"
looks_like = "a kink at a fixed displacement on one side, in large loops only"
told_apart_by = "amplitudes on both sides of the kink"
force = "k_b * max(y - y_b, 0)"
energy = "k_b * max(y - y_b, 0)**2 / 2"
[[parameters]]
symbol = "k_b"
unit = "N/mm"
meaning = "stiffness of the bracket"
start = "0.2 * F_typical / A_typical"
lower = 0
[[parameters]]
symbol = "y_b"
unit = "mm"
meaning = "displacement at which it touches"
start = ["0.3 * A_highest", "0.6 * A_highest", "0.85 * A_highest"]
lower = 0
upper = "A_highest"
"""
)

# %%
# The virtual rig tests a clamp that has such a bracket, of 150 N/mm at 0.6 mm.

rig = f"rig clamp.json -o bracketed --effects {bracket} --set k_b=150,y_b=0.6 --amplitudes 0.3,0.65,1 --frequencies 1,4"
plan = "--temperatures 20,250 --cycles 3 --rate 300"
subprocess.run(
    [sys.executable, "-m", "pipeclamp", *rig.split(), *plan.split()],
    cwd=folder,
    check=True,
)
tests = pc.read_campaign(folder / "bracketed")

# %%
# Fitted with and without it:

bare = pc.identify(tests)
with_bracket = pc.identify(tests, effects=[bracket])
for law in (bare, with_bracket):
    print(law)
with_bracket.to_frame().select("parameter", "value", "standard_error", "unit")[-2:]

# %%
# What the bracket adds to a loop of 1 mm at 1 Hz: the difference of the two laws' forces.

angle = np.linspace(0, 2 * np.pi, 400)
y, v = np.sin(angle), 2 * np.pi * np.cos(angle)
figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
for law, label, colour in (
    (bare, "base law", "#8a99a8"),
    (with_bracket, "with the bracket", "#2b7bba"),
):
    axes.plot(y, law.force(y, v, A=1.0, f=1.0, T=20.0), color=colour, label=label)
axes.axvline(
    with_bracket.values["y_b"],
    color="#c2452d",
    linewidth=0.8,
    linestyle="--",
    label="it touches here",
)
axes.set(xlabel="y / mm", ylabel="F / N")
axes.legend(frameon=False)
axes.grid(alpha=0.3)
