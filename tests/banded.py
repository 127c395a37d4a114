"""A cantilever with a hardening clamp whose law tells how sure it is."""

from __future__ import annotations

from pathlib import Path

from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import Covariance, Foretold, Shares, Spread, write_law

PIPE = """name = "pipe"
pipe = { outer_diameter_mm = 60.3, wall_mm = 3.91, length_m = 3.0, material = "316L" }
ends = { left = "clamped", right = "free" }
clamps = [{ name = "clamp1", position_m = 2.0 }]
probes = [{ name = "tip", position_m = 3.0 }]
excitation = { kind = "base" }
damping = { ratio = 0.01 }
modes = { up_to_Hz = 60 }
"""
SYSTEM = """name = "case"
pipe = { file = "pipe.toml" }
clamps = [{ at = "clamp1", law = "law.json", temperature_C = 20.0, track = true, amplitude_mm = 1, frequency_Hz = 20 }]
excitation = { kind = "sine", acceleration_m_s2 = 1.0, frequency_Hz = 20.0 }
run = { stop_s = 0.2, step_s = 0.001 }
response = { from_Hz = 12.0, to_Hz = 24.0, levels = [LEVEL], dots = 0 }
"""
RUNS, FORM = Shares(stiffness=0.01, damping=0.03), Shares(stiffness=0.02, damping=0.05)
SPREAD = Spread(runs=RUNS, form=FORM, beyond={"A": Foretold(step=0.5, error=Shares(stiffness=0.04, damping=0.1))})


def banded(folder: Path, level: float, *, hard: float = 0.0, spread: Spread | None = SPREAD) -> Path:
    """Write it, and give the path of its SYSTEM.toml."""
    file = open_law("emwm2")
    values = {"k10": 120.0, "k30": hard, "k1_A": 0.0, "k3_A": 0.0, "c0": 1.0, "alpha0": 0.9, "alpha_f": 0.0}
    chosen = {
        name: entry.model_copy(update={"value": values.get(name, entry.value), "state": "fitted"})
        for name, entry in file.coefficients.items()
    }
    matrix = ((4.0, 0.01), (0.01, 0.0025))
    told = {"covariance": Covariance(names=("k10", "c0"), matrix=matrix), "spread": spread}
    write_law(file.model_copy(update={"coefficients": chosen, "name": "hard", **told}), folder / "law.json")
    (folder / "pipe.toml").write_text(PIPE, encoding="utf-8")
    path = folder / "system.toml"
    path.write_text(SYSTEM.replace("LEVEL", str(level)), encoding="utf-8")
    return path
