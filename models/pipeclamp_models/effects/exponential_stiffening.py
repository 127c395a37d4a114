"""Exponential stiffening: dF/dy = k_x (exp(b_x |y|) - 1), a stiffness that grows as an exponential of the stroke.

It is nought at rest, where k1 says all, so that the two don't stand for each other.
"""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.equations.literature import FUNG
from pipeclamp_models.equations.symbols import F_typical, x, y_farthest

k_x, b_x = sp.symbols("k_x b_x", real=True)

STRAIGHT = 30
"""Stroke over 1/b_x from which the force goes straight on: beyond any test, and no number becomes too large there."""

stroke = b_x * sp.Abs(x)
curved = sp.Min(stroke, STRAIGHT)
beyond = sp.Max(stroke - STRAIGHT, 0)
grown = [2.0, 4.0, 8.0]
"""Starts of the largest stroke over 1/b_x."""
rates = [stroke / y_farthest for stroke in grown]

EFFECT = Effect(
    id="exponential_stiffening",
    part="clamp",
    does="a stiffness that grows exponentially with the stroke",
    source=f"{FUNG}: dT/dl in proportion to T + constant, without the stiffness at rest, which is k1's",
    looks_like="tips of large loops bend up, ever more steeply towards the largest ones; small loops don't show it",
    imitated_by=("hardening", "end_stop", "cubic_stiffness", "gas_spring"),
    told_apart_by="larger amplitudes: from step to step the stiffness grows by the same factor, where a power's growth "
    "slackens and a stop's ends",
    parameters=(
        Parameter(
            k_x, "N/mm", "stiffness that is added at the stroke ln 2/b_x",
            tuple(0.2 * F_typical * rate / (sp.exp(end) - 1 - end) for rate, end in zip(rates, grown, strict=True)),
            lower=0.0,
        ),
        Parameter(
            b_x, "1/mm", "growth of the stiffness per stroke", tuple(rates), lower=0.2 / y_farthest,
            upper=20 / y_farthest,
        ),
    ),
    force=k_x / b_x * (sp.exp(curved) * (1 + beyond) - 1 - stroke) * sp.sign(x),
    energy=k_x / b_x**2 * (sp.exp(curved) * (1 + beyond + beyond**2 / 2) - 1 - stroke - stroke**2 / 2),
)  # fmt: skip
