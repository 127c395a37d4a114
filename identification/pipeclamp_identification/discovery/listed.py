"""Effects of the catalogue asked what a term is asked, where no term passes.

A diagnosis names what takes half where little is missing, for any effect takes some of a wrong form. Who seeks a term
asks for less; and effects win ties with terms, so that one which no diagnosis names would leave its user with neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipeclamp_identification.diagnosis.foretold import MEASURE_OF_SHARES, explained_share, takes_part
from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import BEYOND_DOUBT_DRAWS_SHARE, MATERIAL_PART_SHARE
from pipeclamp_identification.diagnosis.verdict import Diagnosis
from pipeclamp_identification.diagnosis.weighing.between_levels import rests_on
from pipeclamp_identification.discovery.columns import TermColumn
from pipeclamp_identification.discovery.guards import Guard, beyond_chance, beyond_the_tests, confirmed, surely_better
from pipeclamp_identification.discovery.hearing import Hurdle
from pipeclamp_identification.discovery.search import screened_columns


@dataclass(frozen=True)
class EffectFound:
    """An effect of the catalogue that passed what a term is asked.

    Attributes:
        judged: the law with it, fitted to all tests.
        guards: what was asked of it.
    """

    judged: Judged
    guards: tuple[Guard, ...]

    @property
    def name(self) -> str:
        """As `add` takes it."""
        return self.judged.effects[0]

    @property
    def passed(self) -> bool:
        """Whether it may take the place of a term."""
        return all(guard.passed for guard in self.guards)


def effect_instead(
    diagnosis: Diagnosis, bar: Hurdle, problem: Problem, columns: Sequence[TermColumn]
) -> EffectFound | None:
    """Give the effect of the catalogue that passes what a term is asked; None where none does.

    Of several that foretell as well, as far as draws of the conditions tell, the likeliest is taken, as of terms. Not
    one that physics speaks against, nor one that needs another beside it.

    Args:
        diagnosis: the law and the effects, fitted to all tests.
        bar: the same without the tests that were kept back, and these.
        problem: the tests that the search saw.
        columns: of all terms beside the law: an effect must explain more than the best of them would by chance.
    """
    on_seen = {one.effects: one for one in bar.listed if not one.objections}
    asked = [one for one in diagnosis.candidates if one.effects in on_seen and not one.objections]
    heard = [EffectFound(one, _guards_of(one, on_seen[one.effects], diagnosis, bar, problem, columns)) for one in asked]
    passed = [one for one in heard if one.passed]
    if not passed:
        return None
    first = min(passed, key=lambda one: one.judged.squares)
    as_well = [one for one in passed if not surely_better(first.judged, one.judged, diagnosis.problem)]
    return min(as_well, key=lambda one: one.judged.akaike)


def _guards_of(
    one: Judged, on_seen: Judged, diagnosis: Diagnosis, bar: Hurdle, problem: Problem, columns: Sequence[TermColumn]
) -> tuple[Guard, ...]:
    part = _takes_a_part(one, diagnosis)
    if not part.passed:
        return (part,)
    fitted, seen, law = on_seen.fitted, on_seen.result.law, bar.law.result.law
    by_chance = screened_columns(columns, fitted.residual, fitted.jacobian, problem.groups).by_chance()
    return (
        part,
        beyond_chance(bar.law.squares - on_seen.squares, by_chance),
        beyond_the_tests(bar.law, on_seen, problem),
        confirmed(law, seen, bar.unseen, problem),
    )


def _takes_a_part(one: Judged, diagnosis: Diagnosis) -> Guard:
    """Ask whether an effect takes a part of what a law misses, as a diagnosis asks but for how large it is."""
    law, problem = diagnosis.law, diagnosis.problem
    words = (
        f"it takes {explained_share(one, law):.0%} of what is missing ({MEASURE_OF_SHARES}); asked is "
        f"{MATERIAL_PART_SHARE:.0%}, and a gain in more than {BEYOND_DOUBT_DRAWS_SHARE:.1%} of draws of them"
    )
    level = rests_on(one, law, problem)
    if level is not None:
        words += f"; but it rests on one level of {level.condition}"
    return Guard("takes a part", level is None and takes_part(one, law, problem), words)
