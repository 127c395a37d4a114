"""Diagnose and add, again and again, until no step lowers the error on left-out conditions; the better of two ways."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pipeclamp_identification.diagnosis.further_test.limits import Limits
from pipeclamp_identification.diagnosis.thresholds import STILL_AS_GOOD
from pipeclamp_identification.workflow.climb import Climber, Fork, Place, Rung, Settled
from pipeclamp_identification.workflow.tests import Diagnosed, Tests
from pipeclamp_models.base.processes import ALONE, Workers
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile

MOST_RUNGS = 12
"""Rungs that a way up the ladder has at most."""
OTHER_WAY_SHARE = 0.5
"""Another effect is worth a way of its own where it takes this share at least of what the best one does."""


def add_until_settled(
    file: LawFile,
    tests: Tests,
    *,
    command: str,
    declared: Sequence[Declaration] = (),
    limits: Limits | None = None,
    workers: Workers = ALONE,
    most: int = MOST_RUNGS,
    seen: Callable[[Diagnosed, LawFile], None] = lambda found, file: None,
    climbed: Callable[[LawFile, tuple[Rung, ...]], None] = lambda file, ladder: None,
) -> Settled:
    """Add the missing effect and diagnose again, while one is missing and the error on left-out conditions falls.

    Of several effects that take much the same part the best is added, or the next where a refit with the best doesn't
    lower the error; where none does, the diagnosis names nothing. Of several that may be the cause none is, but where
    the law has a part already: the proposed test would tell. Beside a part, which may stand for something else, nothing
    is called the cause. After each step the effects so far are asked again:
    one that the law does as well without goes, for good. Where nothing is named, or nothing that is helps, the other
    base laws are tried, and in the place of each effect those that act alike; what does better beyond doubt takes the
    place. Where the law is complete, simpler effects that act alike are tried in the place of each part.

    The part that takes most first may lead astray. Where the ladder ends with something missing that can't be named,
    it is climbed once more from where another effect took nearly as much, or as much, rather one that the end lacks,
    until a law of the first way is met; the way that ends better is taken. Of a dozen further ways none ended better.

    Args:
        file: the law to begin with.
        tests: records, or metrics alone.
        command, declared, limits, workers: as for `add_effect` and `Tests.diagnose`.
        most: rungs at most.
        seen: is given each diagnosis with its law, once what it names has been tried; at last that of the end.
        climbed: is given each law that a rung has come to, with what was done on the way, before it is diagnosed.

    Raises:
        UserError: the data can't serve the law.
    """
    climber = Climber(tests, command, declared, limits, workers, most, seen, climbed)
    way = climber.climb(Place(file))
    assert way.settled is not None  # no other way came before
    first = way.settled
    fork = _fork_worth_climbing(way.forks, first.file) if first.found.verdict == "unknown" else None
    if fork is None:
        return first
    workers.tell(f"another way: {fork.effect} in place of {fork.taken}")
    other = climber.climb_from(fork, first.heldout, way.met).settled
    best = other if other and _ends_better(other, first) else first
    seen(best.found, best.file)
    return best


def _fork_worth_climbing(forks: Sequence[Fork], end: LawFile) -> Fork | None:
    """Give the fork whose other effect comes nearest to what was taken; None where none is near.

    One that the end has all the same comes last: with it first, the way takes much the same in another order.
    """
    near = [fork for fork in forks if fork.share >= OTHER_WAY_SHARE]
    return min(near, key=lambda fork: (fork.effect in end.effects, -fork.share), default=None)


def _ends_better(other: Settled, best: Settled) -> bool:
    """Tell whether a ladder ends with a materially smaller error on left-out conditions, or as small and complete.

    Or, of errors that are as good, with fewer effects: what each of them adds along other motions no sine has asked.
    A law that leaves mean forces open errs by less only since it foretells none of them.
    """
    if other.found.leaves_means_open and not best.found.leaves_means_open:
        return False
    complete = other.found.verdict == "complete" and other.heldout <= best.heldout
    simpler = other.heldout <= best.heldout * STILL_AS_GOOD and len(other.file.effects) < len(best.file.effects)
    return complete or simpler or other.heldout * STILL_AS_GOOD < best.heldout
