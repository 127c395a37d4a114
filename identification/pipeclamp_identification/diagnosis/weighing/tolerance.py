"""How much a law may leave over: what counts as scatter, as the form of its effects, and as explained."""

from __future__ import annotations

from dataclasses import dataclass

from pipeclamp_identification.diagnosis.evidence import LackOfFit
from pipeclamp_identification.diagnosis.foretold import ErrorBeyondScatter, explained_share
from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import (
    FORM_NOISE_SHARE,
    HALF_LEFT_SHARE,
    HALF_TAKEN_SHARE,
    MATERIAL_PART_SHARE,
    REAL_LACK_CHANCE,
    UNEXPLAINED_SHARE,
)


@dataclass(frozen=True)
class Tolerance:
    """Lack of fit that is let pass, as shares of the force noise.

    Attributes:
        complete: below this a law counts as complete.
        form: below this what no effect explains passes for the form of the effects that the law has.
        left: below this, and below a share of what is missing, an effect counts as explaining it; of what a law lacks
            below this, a part takes half at least.
        proved: whether nothing of the law is a mere part. Where something is, its form isn't known, and doubt whether
            the law errs on left-out conditions counts against it.
    """

    complete: float
    form: float
    left: float
    proved: bool = True

    def counted(self, error: ErrorBeyondScatter) -> float:
        """Give what of a law's error on left-out conditions counts against it, as a share of the force noise."""
        return error.sure_share if self.proved else error.share


def is_adequate(lack: LackOfFit, tolerance: Tolerance) -> bool:
    """Tell whether nothing that a law leaves over follows the conditions."""
    return lack.p_value > REAL_LACK_CHANCE or lack.share < tolerance.complete


def is_complete(law: Judged, problem: Problem, tolerance: Tolerance) -> bool:
    """Tell whether what a law leaves over is scatter, such as rigs have, and no more than passes for form."""
    immaterial = law.lack.share < tolerance.complete
    as_rigs_have = not problem.noise.is_no_rigs and law.lack.sure_share <= FORM_NOISE_SHARE
    return is_adequate(law.lack, tolerance) and (immaterial or as_rigs_have)


def may_be_form(law: Judged, tolerance: Tolerance) -> bool:
    """Tell whether what is missing is so small that it may be the form of the effects that the law has."""
    return law.lack.share < tolerance.form


def explains(candidate: Judged, law: Judged, tolerance: Tolerance) -> bool:
    """Tell whether a law leaves over next to nothing of what is missing, or what may be form.

    Of what may be form it takes half of the fit to all tests, too: on left-out conditions next to nothing may be
    missing, half of which is no measure, and of what follows the conditions scatter makes next to nothing sure.
    """
    left, missing = candidate.lack.sure_share, law.lack.share
    least = HALF_TAKEN_SHARE if may_be_form(law, tolerance) else MATERIAL_PART_SHARE
    if left > HALF_LEFT_SHARE * missing or explained_share(candidate, law) < least:
        return False
    if is_adequate(candidate.lack, tolerance):
        return True
    if may_be_form(law, tolerance) and missing**2 - candidate.lack.share**2 < HALF_TAKEN_SHARE * missing**2:
        return False
    return left < tolerance.form or (left < tolerance.left and left < UNEXPLAINED_SHARE * missing)
