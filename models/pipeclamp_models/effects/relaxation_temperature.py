"""Relaxation times over temperature: tau times a_T of Williams, Landel and Ferry, of all that relaxes.

ln a_T = r_T1 t/(1 + 100 K t/w_T), t = (T - T_r)/100 K: r_T1 is the slope at T_r; w_T below it nothing relaxes any more.
T_r is of the temperatures tested the one nearest to T0: a polymer may be stiff as glass at T0 itself.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import FERRY, WILLIAMS
from pipeclamp_models.equations.relaxation_times import ABOVE_STILL, COLDEST, HOTTEST, NEAREST, SLOPE, log_factor
from pipeclamp_models.equations.symbols import T, T_lowest

r_T1, w_T, T_r = sp.symbols("r_T1 w_T T_r", real=True)
STEEPEST = 80.0
"""A polymer's log change per 100 K at its glass transition: ln 10 x 17.44/51.6 per K, their universal constants."""
ELASTOMERS = 25.0 / 3
"""Standard deviation of those of elastomers above theirs."""

EFFECT = Effect(
    id="relaxation_temperature",
    part="clamp",
    does="relaxation times follow the temperature: what relaxes is at another place of its frequencies",
    source=f"{WILLIAMS}; {FERRY}, on time-temperature superposition",
    looks_like="a loop at a higher temperature is as one at a lower frequency: stiffness and damping change with T as "
    "they do with f",
    imitated_by=("damping_temperature", "stiffness_frequency"),
    told_apart_by="a decade of frequency at several temperatures: curves over f lie on one when shifted along log f",
    parameters=(
        Parameter(
            r_T1, "-", "log change of relaxation times per 100 K at T_r", (-1.0, SLOPE, -12.0), -STEEPEST, STEEPEST,
            neutral=0.0, follows=(T,), known_within=ELASTOMERS,
        ),
        Parameter(
            w_T, "K", "how far below T_r nothing relaxes any more", (ABOVE_STILL,) * 3,
            sp.Max(40.0, 1.3 * (NEAREST - T_lowest)), 1000.0, neutral=ABOVE_STILL, follows=(T,), levels=3,
            known_within=50.0,
        ),
        Parameter(
            T_r, "K", "temperature that relaxation times and their change are stated at", (NEAREST,) * 3, lower=0.0,
            stated=True,
        ),
    ),
    scales={"relaxation": sp.exp(log_factor(T - T_r, r_T1, w_T))},
    brings_into_view=(COLDEST, HOTTEST),
)  # fmt: skip
