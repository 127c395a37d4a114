"""Orders of the series law (Eq. 10), chosen by their accuracy on conditions that were left out."""

from __future__ import annotations

from dataclasses import replace

from pipeclamp_identification.fitting.heldout import refitted_nrmse
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.observations import LoopObservations
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_models.effects.damping_series import HIGHEST_ORDER as HIGHEST_DAMPING
from pipeclamp_models.effects.elastic_series import HIGHEST_ORDER as HIGHEST_ELASTIC
from pipeclamp_models.law.law import Structure

WORTH_SHARE = 0.98
"""A higher order stays when it brings the error on left-out conditions below this share of the one before."""


def choose_series(loops: Loops, observations: LoopObservations, structure: Structure) -> Structure:
    """Give the structure on a series base, orders raised in turn while the error on left-out conditions falls.

    Args:
        loops: the tests.
        observations: the same, as observations.
        structure: the effects that are fitted with the series.
    """

    def of(orders: list[int]) -> Structure:
        return replace(structure, base=f"series:{orders[0]}:{orders[1]}")

    def error_of(orders: list[int]) -> float:
        return refitted_nrmse(fit(of(orders), observations).law, loops, observations)

    orders = [1, 1]
    best = error_of(orders)
    raised = True
    while raised:
        raised = False
        for place, highest in ((0, HIGHEST_ELASTIC), (1, HIGHEST_DAMPING)):
            # Odd and even powers do different things: the next order but one may be worth what the next is not.
            for step in (1, 2):
                trial = orders.copy()
                trial[place] += step
                if trial[place] > highest:
                    continue
                error = error_of(trial)
                if error < WORTH_SHARE * best:
                    orders, best, raised = trial, error, True
                    break
    return of(orders)
