"""
Which test next?
================

Two frequencies are too few to tell a stiffness that follows the frequency from a mass that moves with the clamp. The
diagnosis says so, and proposes the test that would tell.
"""

# %%
# A narrow campaign from the virtual rig: three amplitudes, two frequencies, one temperature. The truth, the bundled law
# ``emwm2``, has a stiffness that follows the frequency.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import pipeclamp as pc

folder = Path(tempfile.mkdtemp())
rig = pc.rig(
    "emwm2",
    folder / "narrow",
    amplitudes=[0.3, 0.6, 1.0],
    frequencies=[3.0, 4.0],
    temperatures=[20.0],
    cycles=3,
    rate=240.0,
    force_noise=8.0,
)

# %%
# Two effects explain it equally well.

narrow = rig.tests()
law = pc.identify(narrow)
answer = pc.diagnose(law, narrow, limits="A=0.1..1.5,f=0.5..20,T=20..20")
print(answer)

# %%
# The test that is proposed, as data:

for name, value in answer.next_test.items():
    print(f"{name}: {value}")

# %%
# Both candidates lower the error on left-out conditions, and neither by more than the other:

candidates = answer.to_frame().head(4)
figure, axes = plt.subplots(figsize=(6.4, 2.4), layout="constrained")
axes.barh(
    candidates["effect"].to_list(),
    (100 * candidates["heldout_nrmse"]).to_list(),
    color="#2b7bba",
)
axes.invert_yaxis()
axes.set(xlabel="error on left-out conditions / %")
