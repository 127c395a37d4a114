"""How far a law of A and f is from one with memory, where its A and f are given, solved or tracked.

Run: python build_scripts/benchmarks/law_amplitude.py

The bundled campaign is fitted by a law with two elastic-slip elements and nothing that depends on A or f. A noise-free
virtual campaign of that law is fitted by the base law, whose coefficients do. Both, as FMUs, are then moved along a
steady sine, a slow sweep of falling amplitude, two tones and random motion.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from prescribed_motion import mode_errors, motions

AMPLITUDE, FREQUENCY = 0.5, 3.0
"""mm, Hz: of the motions."""
GIVEN = (0.7, 3.5)
"""A (mm) and f (Hz) of the mode "given": a guess, as an engineer has one before the first run."""

CAMPAIGN = Path(__file__).parents[2] / "identification/pipeclamp_identification/data/campaigns/clamp_a"
FROZEN = ",".join(f"{name}=0" for name in ("k1_A", "k1_T", "k3_A", "k3_T", "c_A", "c_f", "alpha_A", "alpha_f"))
GRID = (
    "--temperatures",
    "20",
    "--amplitudes",
    "0.2,0.35,0.5,0.7,1.0",
    "--frequencies",
    "1,2,3,5",
    "--force-noise",
    "0",
)


def pipeclamp(folder: Path, *words: str) -> None:
    """Run a command in a folder."""
    subprocess.run([sys.executable, "-m", "pipeclamp", *words], cwd=folder, check=True, capture_output=True)


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        pipeclamp(folder, "identify", str(CAMPAIGN), "-o", "memory.json", "--effects", "memory:2", "--freeze", FROZEN)
        pipeclamp(folder, "rig", "memory.json", "-o", "virtual", *GRID)
        pipeclamp(folder, "identify", "virtual", "-o", "law.json")
        for law in ("memory", "law"):
            pipeclamp(folder, "build-fmu", f"{law}.json", "-o", f"{law}.fmu")
        print(f"{'':12s}{'given':>9s}{'solved':>9s}{'tracked':>9s}   rms force error against the law with memory")
        for kind, motion in motions(AMPLITUDE, FREQUENCY).items():
            errors = mode_errors(folder / "law.fmu", folder / "memory.fmu", motion, GIVEN)
            print(f"{kind:12s}" + "".join(f"{error:9.1%}" for error in errors.values()))


if __name__ == "__main__":
    main()
