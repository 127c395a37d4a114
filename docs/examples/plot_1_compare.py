"""
A law against loops
===================

A law is fitted to the bundled campaign ``clamp_a`` and held against it: how much does it err, and where?
"""

# %%
# Read the tests, fit the base law to all runs, compare. All three answers are those of the commands
# ``pipeclamp identify`` and ``pipeclamp compare``.

import matplotlib.pyplot as plt
import numpy as np

import pipeclamp as pc

tests = pc.read_campaign("clamp_a")
law = pc.identify(tests)
comparison = pc.compare(law, tests)
print(comparison)

# %%
# A result shows itself in a notebook. Here are the law's parameters with their standard errors.

law.to_frame().select("parameter", "value", "standard_error", "unit", "meaning")

# %%
# The error by temperature stands beside the scatter, which no law can explain: the law errs most at 20 and 300 °C.
# Damping that follows the temperature is missing.

by_temperature = comparison.to_dict()["where"]["conditions"]["temperature_C"]
temperatures = [part["part"] for part in by_temperature]
figure, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
axes.bar(
    temperatures,
    [100 * part["nrmse"] for part in by_temperature],
    color="#2b7bba",
    label="law",
)
axes.bar(
    temperatures,
    [100 * part["noise_nrmse"] for part in by_temperature],
    color="#b7c4d1",
    label="scatter",
)
axes.set(xlabel="T / °C", ylabel="error / % of the rms force")
axes.legend(frameon=False)

# %%
# The law's force is a function of displacement and velocity (mm, mm/s; N). Its loops at 20 and 300 °C, for one motion:

amplitude, frequency = 0.5, 3.0
angle = np.linspace(0, 2 * np.pi, 400)
y = amplitude * np.sin(angle)
v = 2 * np.pi * frequency * amplitude * np.cos(angle)
figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
for temperature, colour in ((20.0, "#2b7bba"), (300.0, "#c2452d")):
    force = law.force(y, v, A=amplitude, f=frequency, T=temperature)
    axes.plot(y, force, color=colour, label=f"{temperature:.0f} °C")
axes.set(xlabel="y / mm", ylabel="F / N")
axes.legend(frameon=False)
axes.grid(alpha=0.3)
