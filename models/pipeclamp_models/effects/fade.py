"""Fade or run-in: damping and slip forces times 1 + d_N (1 - exp(-N/N_d)) with the load cycles N.

Tests that begin later don't show a drift that was over before: it would only scale what nobody has measured.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import DIXON, LOMIENTO
from pipeclamp_models.equations.symbols import N, N_highest, N_lowest

d_N, N_d = sp.symbols("d_N N_d", real=True)
drift = 1 + d_N * (1 - sp.exp(-N / N_d))

EFFECT = Effect(
    id="fade",
    part="clamp",
    does="damping and slip forces drift with load cycles: fade, run-in, wear",
    source=f"{LOMIENTO}: sliding friction that falls with the cycles; {DIXON}, on fade of dampers that warm up. The "
    "exponential is the simplest drift that ends",
    looks_like="a trend of the loop's area along the cycles inside a record and from record to record",
    imitated_by=("damping_temperature", "slip_temperature", "loosening"),
    told_apart_by="the first test repeated at the end: the loop's area doesn't come back; after a pause what warmth "
    "took does",
    parameters=(
        Parameter(
            d_N, "-", "share by which damping and slip forces have changed in the end", (-0.02,) * 3, -0.95, 5.0,
            neutral=0.0, follows=(N,),
        ),
        Parameter(
            N_d, "-", "cycles in which 63% of the change happen", (0.1 * N_highest, 0.3 * N_highest, N_highest),
            lower=N_lowest, upper=3.0 * N_highest, neutral=1000.0, follows=(N,),
        ),
    ),
    scales={"damping": drift, "slip": drift},
)  # fmt: skip
