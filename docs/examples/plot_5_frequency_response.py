"""
A pipe and its clamp: frequency response, cold and hot
======================================================

A 10 m pipe full of water, pinned at both ends, is held by a clamp at 1.5 m and shaken at its supports. Harmonic balance
gives its steady motions without integrating in time.
"""

# %%
# The pipe and the coupled system are described by two files. The clamp obeys a bundled law.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pipeclamp as pc

folder = Path(tempfile.mkdtemp())
(folder / "pipe.toml").write_text("""
name = "pipe"
[pipe]
outer_diameter_mm = 114.3
wall_mm = 3.6
length_m = 10.0
material = "carbon steel"
fluid = "water"
[ends]
left = "pinned"
right = "pinned"
[[clamps]]
name = "clamp1"
position_m = 1.5
[[probes]]
name = "midspan"
position_m = 5.5
[damping]
ratio = 0.005
[modes]
up_to_Hz = 60.0
""")
(folder / "system.toml").write_text("""
name = "pipe with one clamp"
[pipe]
file = "pipe.toml"
[[clamps]]
at = "clamp1"
law = "emwm2"
temperature_C = 20.0
track = true
[excitation]
kind = "sine"
acceleration_m_s2 = 0.2
frequency_Hz = 4.0
[run]
stop_s = 10.0
step_s = 0.004
scheme = "iterated"
[response]
from_Hz = 4.0
to_Hz = 4.8
temperatures_C = [20.0, 300.0]
dots = 0
""")

# %%
# A curve for each temperature of the clamp, and its highest motion at each place:

response = pc.response(folder / "system.toml")
response.peaks()

# %%
# Amplitude at midspan over the frequency: hot, the clamp damps less, and the peak is higher. Motions that are unstable
# would be dotted: a small disturbance grows there, so that no test would show them.

states = response.to_frame()
figure, axes = plt.subplots(figsize=(7.2, 4.2), layout="constrained")
for (temperature,), curve in states.group_by("temperature [degC]", maintain_order=True):
    colour = "#2b7bba" if temperature == 20.0 else "#c2452d"
    frequency, midspan = (
        curve["frequency [Hz]"].to_numpy(),
        curve["midspan.s [mm]"].to_numpy(),
    )
    stable = curve["stable"].to_numpy() == 1
    axes.plot(
        frequency,
        np.where(stable, midspan, np.nan),
        color=colour,
        label=f"{temperature:.0f} °C",
    )
    axes.plot(frequency, np.where(stable, np.nan, midspan), color=colour, linestyle=":")
axes.set(xlabel="f / Hz", ylabel="midspan / mm")
axes.legend(frameon=False)
axes.grid(alpha=0.3)
