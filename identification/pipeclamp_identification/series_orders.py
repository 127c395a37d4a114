"""Orders of the series law (Eq. 10), chosen by their accuracy on conditions that were left out."""

from __future__ import annotations

import numpy as np

from pipeclamp.effects.damping_series import HIGHEST_ORDER as HIGHEST_DAMPING
from pipeclamp.effects.elastic_series import HIGHEST_ORDER as HIGHEST_ELASTIC
from pipeclamp.law import Structure, compose
from pipeclamp.response import respond
from pipeclamp_identification.fit import fit
from pipeclamp_identification.heldout import Rows, condition_groups, heldout_nrmse
from pipeclamp_identification.loops import Loops
from pipeclamp_identification.observations import LoopObservations

FOLDS = 4
WORTH = 0.98
"""A higher order stays when it brings the error on left-out conditions below this share of the one before."""


def choose_series(loops: Loops, observations: LoopObservations, effects: tuple[str, ...]) -> str:
    """Give the name of the series base, orders raised in turn while the error on left-out conditions falls.

    Args:
        loops: the tests.
        observations: the same, as observations.
        effects: effects that are fitted with the series.
    """
    groups = condition_groups(loops.amplitude_mm, loops.frequency_Hz)
    orders = [1, 1]
    best = _heldout(orders, effects, observations, groups)
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
                error = _heldout(trial, effects, observations, groups)
                if error < WORTH * best:
                    orders, best, raised = trial, error, True
                    break
    return f"series:{orders[0]}:{orders[1]}"


def _heldout(orders: list[int], effects: tuple[str, ...], observations: LoopObservations, groups: Rows) -> float:
    structure = Structure(f"series:{orders[0]}:{orders[1]}", effects)
    equations = compose(structure)

    def squared_errors(used: Rows, left_out: Rows) -> tuple[float, float]:
        result = fit(structure, observations.rows(used))
        law = result.law
        beyond = observations.rows(left_out)
        response = respond(equations, law.vector(equations), (law.v_r, law.y_r), beyond.motion)
        return beyond.squared_error(response)

    return heldout_nrmse(groups, min(FOLDS, int(np.max(groups)) + 1), squared_errors)
