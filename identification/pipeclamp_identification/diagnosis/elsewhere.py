"""Where a law that fits its tests may err all the same: on conditions, on levels, and beyond harmonics that it wasn't
fitted to.

Each has squares of its own. A campaign of other conditions would show them all, so they count together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.diagnosis.beyond_harmonics import BeyondHarmonics, beyond_harmonics
from pipeclamp_identification.diagnosis.foretold import foretold
from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import FORM_NOISE_SHARE
from pipeclamp_identification.diagnosis.weighing.between_levels import LeftOutLevel, worst_level
from pipeclamp_identification.diagnosis.weighing.reasons import between_words
from pipeclamp_identification.diagnosis.weighing.tolerance import Tolerance, is_adequate
from pipeclamp_identification.loops.loops import HIGHEST_HARMONIC, Loops


@dataclass(frozen=True)
class Elsewhere:
    """What a law errs elsewhere than on its tests' kept harmonics.

    Attributes:
        left_out: on groups that are left out, scatter taken off, as a share of the noise; zero where nothing that the
            law leaves over follows the conditions.
        worst: what it errs more on a level between others that is left out; None where no level lies between.
        beyond: what it leaves over beyond the kept harmonics.
    """

    left_out: float
    worst: LeftOutLevel | None
    beyond: BeyondHarmonics

    @property
    def contradiction(self) -> str:
        """Why the law isn't complete; empty where all of this together passes for form."""
        if self.worst is not None and self.worst.share > FORM_NOISE_SHARE:
            return between_words(self.worst)
        if self.beyond.sure_share > FORM_NOISE_SHARE:
            return self.beyond.words()
        return self._together()

    def _together(self) -> str:
        """Say that what passes for form one by one doesn't together; empty where it does."""
        left_out, beyond = self.left_out, self.beyond.sure_share
        more, level = 0.0, ""
        if self.worst is not None:
            more = self.worst.share
            at = f"{self.worst.condition} = {self.worst.level}"
            level = f", by {more:.2g} more at {at} when fitted to the other levels"
        whole = math.hypot(left_out, more, beyond)
        if whole <= FORM_NOISE_SHARE:
            return ""
        return (
            f"in units of the force noise the law errs by {left_out:.2g} on left-out conditions{level}, and by "
            f"{beyond:.2g} beyond harmonic {HIGHEST_HARMONIC}: {whole:.2g} together, more than passes for form"
        )


def elsewhere(law: Judged, problem: Problem, tolerance: Tolerance, campaign: Campaign, loops: Loops) -> Elsewhere:
    """Tell what a law errs elsewhere than on its tests' kept harmonics.

    Args:
        law: as fitted to all tests.
        problem: the data.
        tolerance: says whether doubt about left-out conditions counts against the law.
        campaign: the tests.
        loops: `loops_of(campaign)`.
    """
    # Where nothing follows the conditions, fits to fewer tests only show what scatter makes of them.
    left_out = 0.0 if is_adequate(law.lack, tolerance) else tolerance.counted(foretold(law, problem))
    return Elsewhere(left_out, worst_level(law, problem), beyond_harmonics(law.result.law, campaign, loops))
