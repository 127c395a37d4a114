"""An excitation as an FMI 2.0 co-simulation slave: samples at equal steps, linear between them, zero after the last.

The builder makes one module of this file, `plain` and generated samples in place of `stand_in_samples`.
"""

from __future__ import annotations

import math
from typing import Any

from pipeclamp_fmu.slaves.plain import Fmi2Slave
from pipeclamp_fmu.slaves.stand_in_samples import STEP, VALUES

OUTPUTS = ("signal",)


def interpolated(time: float) -> float:
    """Give the excitation at a time in s."""
    place = max(time, 0.0) / STEP
    index = round(place)
    if abs(place - index) > 1e-9 * place:  # more than the rounding of a sum of steps
        index = int(place)
    share = max(place - index, 0.0) if abs(place - index) > 1e-9 * place else 0.0
    before, after = (VALUES[i] if i < len(VALUES) else 0.0 for i in (index, index + 1))
    return before + share * (after - before)


class ExcitationSlave(Fmi2Slave):
    """A signal over time.

    Attributes:
        _start: of the run, s.
    """

    KEPT = ("_start",)

    def __init__(self, **kwargs: Any) -> None:
        super().__init__((), (), OUTPUTS, (), (), kwargs)
        self._start = 0.0

    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        """Learn when the run starts."""
        self._start = start_time if math.isfinite(start_time) else 0.0

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Move to the end of the step; refuse what can't be."""
        end = current_time + step_size
        if self._lost or not (step_size > 0.0 and math.isfinite(end)):
            return self._refuse(current_time, step_size, self._lost or "expected a finite step above 0 s")
        self._reals[0] = interpolated(end)
        return True

    def _evaluate_start(self) -> None:
        self._reals[0] = interpolated(self._start)
