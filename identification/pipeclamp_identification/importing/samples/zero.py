"""A displacement whose zero isn't where the clamp rests: an absolute position, or a sensor that wasn't set to zero.

A law takes a mean displacement for a real one. A spring that was moved so far would answer with a mean force; where no
run has one, it wasn't moved.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeclamp_identification.campaign.seen import SeenRecord, SeenSine
from pipeclamp_models.base.arrays import Array

FAR = 2.0
"""A mean displacement lies far off where it exceeds so many of the largest amplitudes: clamps are held within them."""
UNANSWERED = 0.1
"""Share of stiffness times mean displacement that a mean force reaches where the displacement is real: a stiffness that
softens with the power -0.4 of the amplitude still answers with a third of it at fifteen amplitudes."""


def zeros_elsewhere(runs: Sequence[SeenRecord]) -> Array | None:
    """Give what is to be taken off each run's displacement, mm, shape (n,); None where its zero may be the clamp's.

    It is one for all runs where their means lie within the largest amplitude of each other: those differences may be
    real. Else the sensor was set anew, and it is each run's own mean.
    """
    seen = [run for run in runs if isinstance(run, SeenSine)]
    if not seen or len(seen) < len(runs):
        return None
    mean = np.array([float(np.mean(one.by_cycle.displacement[:, 0].real)) for one in seen])
    force = np.array([float(np.mean(one.by_cycle.force[:, 0].real)) for one in seen])
    stiffness = np.array([one.shown.stiffness.real for one in seen])
    largest = max(one.shown.amplitude_mm for one in seen)
    far, unanswered = np.abs(mean) > FAR * largest, np.abs(force) < UNANSWERED * stiffness * np.abs(mean)
    if not np.all(far & unanswered):
        return None
    common = float(np.median(mean))
    return np.full(len(mean), common) if np.all(np.abs(mean - common) <= largest) else mean


def zero_words(zeros: Array) -> str:
    """Say that zeros were taken off, and what is to be done where a mean displacement was real."""
    least, most = float(np.min(zeros)), float(np.max(zeros))
    shown = f"{least:.5g} mm" if least == most else f"{least:.5g} to {most:.5g} mm, each run's own,"
    return (
        f"the displacement's zero is not where the clamp rests: a mean of {shown} is taken off, for no mean force "
        "answers it"
    )
