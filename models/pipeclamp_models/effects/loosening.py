"""Loosening or run-in: stiffness times 1 + l (1 - exp(-N/N_l)) with the load cycles N, of which tests see a part."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import BOGRAD, JUNKER
from pipeclamp_models.equations.symbols import N, N_highest, N_lowest

l_N, N_l = sp.symbols("l_N N_l", real=True)

EFFECT = Effect(
    id="loosening",
    part="clamp",
    does="stiffness drifts with load cycles: loosening, run-in",
    source=f"{JUNKER}; {BOGRAD}, on joints. The exponential is the simplest drift that ends",
    looks_like="a trend of stiffness along the cycles inside a record and from record to record",
    imitated_by=("contact_growth", "damping_temperature", "fade"),
    told_apart_by="the first test repeated at the end: stiffness doesn't come back",
    parameters=(
        Parameter(
            l_N, "-", "share by which stiffness has changed in the end", (-0.02,) * 3, -0.95, 5.0, neutral=0.0,
            follows=(N,),
        ),
        Parameter(
            N_l,
            "-",
            "cycles in which 63% of the change happen",
            (0.1 * N_highest, 0.3 * N_highest, N_highest),
            lower=N_lowest,
            upper=3.0 * N_highest,
            neutral=1000.0,
            follows=(N,),
        ),
    ),
    scales={"stiffness": 1 + l_N * (1 - sp.exp(-N / N_l))},
)  # fmt: skip
