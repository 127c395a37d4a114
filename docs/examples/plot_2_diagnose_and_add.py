"""
Find what a law lacks, and add it
=================================

A clamp that touches a stop at large displacements is tested on the virtual rig; the base law doesn't know of stops.
The diagnosis has to find it.
"""

# %%
# The virtual rig tests a clamp that obeys the base law, with an end stop besides, at three
# amplitudes, two frequencies and two temperatures, with noise.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import pipeclamp as pc

folder = Path(tempfile.mkdtemp())
clamp = pc.identify(pc.read_campaign("clamp_a"))
rig = pc.rig(
    clamp,
    folder / "stopped",
    effects="end_stop",
    values={"k_e": 600.0, "y_e": 0.7},
    amplitudes=[0.4, 0.75, 1.0],
    frequencies=[1.0, 4.0],
    temperatures=[20.0, 150.0],
    cycles=4,
    rate=300.0,
    force_noise=6.0,
)

# %%
# Fit the base law and ask what it lacks. Every effect of the catalogue is refitted together with the whole law, and
# judged on conditions that were left out.

tests = rig.tests()
law = pc.identify(tests)
answer = pc.diagnose(law, tests)
print(answer)

# %%
# The candidates, best first, with the error on left-out conditions:

answer.to_frame()

# %%
# Add what is missing. The answer itself says what that is.

better = pc.add(law, answer, tests)
print(better)

# %%
# The stop was hidden at 0.7 mm with 600 N/mm. What came back, with standard errors:

better.to_frame().select("parameter", "value", "standard_error", "unit")[-2:]

# %%
# And what is left is scatter:

errors = {
    "base law": pc.compare(law, tests),
    "+ " + better.effects[-1]: pc.compare(better, tests),
}
figure, axes = plt.subplots(figsize=(6.4, 2.2), layout="constrained")
axes.barh(list(errors), [100 * each.nrmse for each in errors.values()], color="#2b7bba")
axes.axvline(100 * errors["base law"].noise_nrmse, color="#c2452d", label="scatter")
axes.invert_yaxis()
axes.set(xlabel="error / % of the rms force")
axes.legend(frameon=False)
