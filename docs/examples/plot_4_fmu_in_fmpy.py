"""
The clamp as an FMU, in fmpy
============================

A law becomes an FMU, and fmpy moves it: a sine whose amplitude grows, with the FMU following amplitude and frequency by
itself (``track``).
"""

# %%
# Build the FMU of a bundled law.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from fmpy import simulate_fmu

import pipeclamp as pc

fmu = pc.build_fmu("emwm2", Path(tempfile.mkdtemp()) / "clamp.fmu")
print(fmu.name, f"{fmu.stat().st_size / 1024:.0f} kB")

# %%
# The motion in SI units: displacement, velocity and temperature. fmpy sets at a step's beginning what the clamp takes
# for its end, so that they are handed over a step early.

frequency, step = 3.0, 1e-3
time = np.arange(0.0, 6.0, step)
angle = 2 * np.pi * frequency * time
amplitude = np.interp(time, [0, 2, 4, 6], [0.2e-3, 0.2e-3, 0.8e-3, 0.8e-3])
motion = np.empty(
    len(time),
    dtype=[(name, float) for name in ("time", "flange.s", "flange.v", "T_in")],
)
motion["time"] = time - step
motion["flange.s"] = amplitude * np.sin(angle)
motion["flange.v"] = np.gradient(motion["flange.s"], time)
motion["T_in"] = 293.15

# %%
# Run it.

result = simulate_fmu(
    str(fmu),
    stop_time=float(time[-1]),
    output_interval=step,
    input=motion,
    start_values={"track": True, "A": 0.2e-3, "f": frequency, "T": 293.15},
    output=["flange.f", "A_used", "f_used", "inRange", "energyDissipated"],
)
print(
    f"dissipated: {result['energyDissipated'][-1]:.2f} J; inside the law's data: {bool(result['inRange'][-1])}"
)

# %%
# The loops, and the amplitude that the law was taken for: the FMU averages over one and a half periods.

figure, (loops, used) = plt.subplots(1, 2, figsize=(8.4, 3.6), layout="constrained")
s = 1e3 * np.interp(result["time"], time, motion["flange.s"])
loops.plot(s, result["flange.f"], color="#2b7bba", linewidth=0.8)
loops.set(xlabel="y / mm", ylabel="F / N")
used.plot(time, 1e3 * amplitude, color="#8a99a8", label="of the motion")
used.plot(
    result["time"], 1e3 * result["A_used"], color="#2b7bba", label="used by the law"
)
used.set(xlabel="t / s", ylabel="A / mm")
used.legend(frameon=False)
for axes in (loops, used):
    axes.grid(alpha=0.3)
