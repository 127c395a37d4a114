"""How often the same measurement would have to be made to tell apart what it can't tell once."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt

import numpy as np
from scipy.special import ndtri

from pipeclamp_identification.attribution.next_test import PipeTestProposal
from pipeclamp_identification.attribution.verdict import RULED_OUT_SQUARES, Attribution

MISSED_CHANCE = 0.05
"""With which the repeats still don't tell."""
MOST_TIMES = 100
"""More repeats are no test that anybody makes."""


@dataclass(frozen=True)
class Repeats:
    """The same measurement again.

    Attributes:
        times: in all.
        apart: standard deviations between the best explanation and the one nearest to it, measured once.
    """

    times: int
    apart: float

    def words(self) -> str:
        """Say how often, and why."""
        return (
            "No other level, frequency or probe was found that would tell them apart. Measure the same "
            f"{self.times} times, or with {sqrt(self.times):.2g} times less noise: measured once, the nearest two are "
            f"{self.apart:.1f} standard deviations apart."
        )


NextMeasurement = PipeTestProposal | Repeats


def repeats(found: Attribution) -> Repeats | None:
    """Give how often the same measurement would tell the named candidates apart; None where no number would.

    Squares between two candidates grow with the number of repeats. With d^2 of them, twice the log of the likelihood
    ratio is normal, with mean d^2 and standard deviation 2 d, where the one is true and the other isn't.
    """
    best, *rivals = found.named
    off = [np.linalg.norm(best.refit.residual - rival.refit.residual) for rival in rivals]
    apart = float(min(off, default=0.0)) / sqrt(best.overdispersion)
    quantile = -float(ndtri(MISSED_CHANCE))
    enough = quantile + sqrt(quantile**2 + RULED_OUT_SQUARES)
    if apart < enough / sqrt(MOST_TIMES):
        return None
    return Repeats(max(2, ceil((enough / apart) ** 2)), apart)
