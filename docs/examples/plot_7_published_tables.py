"""
A law from published tables
===========================

Where only dW and W were published, a campaign holds these metrics without records. The tables of Jiang et al.,
*Symmetry* 2020, 12(8), 1283, come with the program: 11 conditions of one clamp.
"""

# %%
# Read them, fit the base law and the law with an effect, and compare. Errors are rms log ratios of dW and W.

import matplotlib.pyplot as plt

import pipeclamp as pc

tables = pc.read_campaign("emwm2_tables")
base = pc.identify(tables)
better = pc.add(base, "damping_temperature", tables)
for law in (base, better):
    print(pc.compare(law, tables))

# %%
# What was measured:

measured = tables.to_frame()
shown = [
    "amplitude_mm",
    "frequency_Hz",
    "temperature_C",
    "dissipated_energy_J",
    "max_elastic_energy_J",
    "loss_factor",
]
measured.select(shown)

# %%
# What a cycle dissipates falls up to 200 °C and rises again. A power of T can't do both; ``damping_temperature`` can.

by_temperature = measured.filter(
    (measured["amplitude_mm"] == 0.8) & (measured["frequency_Hz"] == 3.0)
)
by_temperature = by_temperature.sort("temperature_C")
figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
axes.plot(
    by_temperature["temperature_C"],
    by_temperature["dissipated_energy_J"],
    "o-",
    color="#2b7bba",
)
axes.set(xlabel="T / °C", ylabel="dW / J", title="0.8 mm, 3 Hz")
axes.grid(alpha=0.3)

# %%
# Few rows name little. ``pipeclamp diagnose`` says which effects they show, and on which single rows each rests.
