"""The command to run after a comparison; it stands apart, since most commands do without what it asks."""

from __future__ import annotations

import numpy as np

from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.diagnosis.further_test.limits import Limits, limits_words, reach_around
from pipeclamp_identification.diagnosis.thresholds import FEWEST_RUNS
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.workflow.along_free import along_free
from pipeclamp_identification.workflow.next_command import PLANNED, stem_of
from pipeclamp_identification.workflow.tests import Held
from pipeclamp_models.base.shell import shell_line
from pipeclamp_models.base.units import CELSIUS


def after_comparison(law: str, tests: str, held: Held) -> str:
    """Give the shell line to run after a comparison: what is missing, if anything, or the tests that would tell.

    Args:
        law, tests: as for `next_command`.
        held: the law against the tests. A diagnosis asks for loops, and for more than a few: these call for a campaign
            around them. Free motions alone call for the clamp's FMU where scatter explains what the law errs along
            them, else for a campaign of sines that reaches as far as they do.
    """
    if isinstance(held, Comparison) and 0 < len(held.runs) < FEWEST_RUNS:
        return _plan_line(law, _around(held.loops), held)
    if not isinstance(held, Comparison) or held.runs:
        return shell_line("diagnose", law, tests, "--report", "diagnosis.html")
    found = along_free(held.free)
    if found.scatter_explains:
        return shell_line("build-fmu", law, "-o", f"{stem_of(law)}.fmu", "--track")
    return _plan_line(law, found.reach, held)


def _plan_line(law: str, reach: Limits, held: Comparison) -> str:
    """Give the line that plans tests within this reach; frequencies mean nothing where no time was measured."""
    stated = reach if held.campaign.time_measured else reach.untimed
    return shell_line("plan", "-o", PLANNED, "--law", law, "--limits", limits_words(stated))


def _around(loops: Loops) -> Limits:
    """Give what a campaign reaches that goes on around a few tests."""
    A, f = ((float(values.min()), float(values.max())) for values in (loops.amplitude_mm, loops.frequency_Hz))
    known = loops.temperature_K[np.isfinite(loops.temperature_K)] - CELSIUS
    T = (float(known.min()), float(known.max())) if known.size else Limits().temperature
    return reach_around(A, f, T, None)
