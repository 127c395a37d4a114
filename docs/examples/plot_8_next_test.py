"""
Which test next?
================

Two frequencies are too few to tell a stiffness that follows the frequency from a mass that moves with the clamp. The
diagnosis says so, and proposes the test that would tell.
"""

# %%
# A narrow campaign from the virtual rig: three amplitudes, two frequencies, one temperature. The truth, the bundled law
# ``emwm2``, has a stiffness that follows the frequency.

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import pipeclamp as pc

folder = Path(tempfile.mkdtemp())


def pipeclamp(words):
    """Run a command in the folder."""
    subprocess.run(
        [sys.executable, "-m", "pipeclamp", *words.split()], cwd=folder, check=True
    )


plan = "--temperatures 20 --cycles 3 --rate 240 --force-noise 8"
pipeclamp(f"rig emwm2 -o narrow --amplitudes 0.3,0.6,1 --frequencies 3,4 {plan}")

# %%
# Two effects explain it equally well.

narrow = pc.read_campaign(folder / "narrow")
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
