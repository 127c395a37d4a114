"""The macro step that other people's masters may take: they couple in parallel, and don't say when it is too long."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, inf, log2
from pathlib import Path

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.run import run_described
from pipeclamp_system.cosim.step_error import step_error
from pipeclamp_system.description.system import SystemDescription

MOST_STEPS_OF_A_TRIAL = 400_000
"""Of a run that looks for the step."""

PROPORTIONAL = 0.25
"""Up to such a share of the motion and of the energy, what is wrong is taken to fall as the step does."""


@dataclass(frozen=True)
class ParallelStep:
    """What was found by co-simulating in parallel.

    Attributes:
        step: the longest that can be trusted, s: the run's own, halved; None where none is known.
        tried: the shortest that was tried, s.
        error: of the displacement in that one, as `step_error` gives it; infinite where it isn't known.
    """

    step: float | None
    tried: float
    error: float


def parallel_step(system: SystemDescription, folder: Path, where: str, tell: Progress = silent) -> ParallelStep:
    """Find the longest macro step in which a parallel master gives a result that can be trusted.

    Steps are halved until it does; where that would take too many steps, the last one says how much shorter still.

    Args:
        system: its FMUs finished.
        folder: what its paths are relative to.
        where: named in errors.
        tell: told what is tried.
    """
    # An SSP holds the A and f that a solution would start from.
    clamps = tuple(clamp.model_copy(update={"solve": False}) for clamp in system.clamps)
    step, before = 2 * system.run.even_step_s, None
    while True:
        tell(f"parallel steps of {step:.3g} s")
        run = system.run.model_copy(update={"scheme": "parallel", "step_s": step, "energy_tolerance": None})
        result = _attempt(system.model_copy(update={"clamps": clamps, "run": run}), folder, where)
        error = inf
        if result is not None and before is not None:
            error = step_error(result, before)
            result = replace(result, step_error=error)
            if result.trusted:
                return ParallelStep(result.step, result.step, error)
        if step / 2 < system.run.stop_s / MOST_STEPS_OF_A_TRIAL:
            return ParallelStep(None if result is None else _foretold(result, error), step, error)
        step, before = step / 2, result


def _foretold(result: CosimResult, error: float) -> float | None:
    """Give the step, halved from a result's, in which what is wrong with it would be small enough; None: not known."""
    wrong = max(error, result.coupling_share, result.energy.clamps_share)
    if wrong > PROPORTIONAL or result.hidden_share > result.trusted_share:
        return None
    return float(result.step / 2 ** max(1, ceil(log2(max(wrong, result.trusted_share) / result.trusted_share))))


def _attempt(system: SystemDescription, folder: Path, where: str) -> CosimResult | None:
    """Run; None where it diverges."""
    try:
        return run_described(system, folder, where, checked=False)
    except UserError:
        return None
