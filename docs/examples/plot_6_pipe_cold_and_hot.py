"""
Co-simulation of a pipe and its clamp, cold and hot
===================================================

A 10 m pipe full of water, pinned at both ends and held by a clamp at 1.5 m, is shaken at its supports. Pipe and clamp
are FMUs, coupled by iteration in steps of 4 ms.
"""

# %%
# Two files describe the pipe and the coupled system. The clamp obeys a bundled law; it follows amplitude and frequency
# of its own motion (``track``).

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

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
amplitude_mm = 0.3
frequency_Hz = 4.3
[excitation]
kind = "sine"
acceleration_m_s2 = 0.2
frequency_Hz = 4.3
[run]
stop_s = 15.0
step_s = 0.004
scheme = "iterated"
""")

# %%
# Co-simulate at both temperatures. Each result says whether it is to be trusted: the error of the macro step, the
# energy that the coupling makes, and motion between the steps are watched.

results = {}
for temperature in (20.0, 300.0):
    values = {"system.clamps.clamp1.temperature_C": temperature}
    results[temperature] = pc.cosim(folder / "system.toml", values=values)
    print(
        f"{temperature:.0f} °C: {results[temperature].amplitude('midspan'):.2f} mm at midspan"
    )
results[20.0]

# %%
# Displacement at midspan, and the clamp's last loops.

figure, (motion, loop) = plt.subplots(1, 2, figsize=(8.4, 3.6), layout="constrained")
for (temperature, result), colour in zip(
    results.items(), ("#2b7bba", "#c2452d"), strict=True
):
    columns = result.to_frame()
    motion.plot(
        columns["time"],
        1e3 * columns["midspan.s"],
        color=colour,
        linewidth=0.7,
        label=f"{temperature:.0f} °C",
    )
    last = columns[-120:]
    loop.plot(1e3 * last["clamp1.s"], last["clamp1.f"], color=colour, linewidth=0.8)
motion.set(xlabel="t / s", ylabel="midspan / mm")
motion.legend(frameon=False)
loop.set(xlabel="clamp / mm", ylabel="F / N")
for axes in (motion, loop):
    axes.grid(alpha=0.3)
