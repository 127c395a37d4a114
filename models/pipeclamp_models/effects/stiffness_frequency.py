"""Stiffness over frequency: stiffness times (f/f0)^k_f."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, exponent
from pipeclamp_models.equations.literature import BAGLEY, JIANG
from pipeclamp_models.equations.symbols import f, f_0

k_f = sp.Symbol("k_f", real=True)

EFFECT = Effect(
    id="stiffness_frequency",
    part="clamp",
    does="stiffness follows a power of the frequency",
    source=f"{JIANG}, Table 2: W falls by 4.6% from 1 to 5 Hz; {BAGLEY}: powers of the frequency",
    looks_like="stiffness wrong by the same share at every A, and that share changes with f",
    imitated_by=("inertia", "relaxation", "relaxation_spread"),
    told_apart_by="a wider range of frequency: inertia grows as f^2, relaxation levels off and widens the loop",
    parameters=(exponent(k_f, "the stiffness", f, 1.0, -0.03),),
    scales={"stiffness": (f / f_0) ** k_f},
)
