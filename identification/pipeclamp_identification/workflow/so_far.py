"""How far a ladder has come: what is told while it is climbed, and the law that stays where it is stopped."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import takewhile
from typing import TYPE_CHECKING

from pipeclamp_models.base.digits import error_goes
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.file import LawFile

if TYPE_CHECKING:
    from pipeclamp_identification.workflow.climb import Rung


class SoFar:
    """The laws that a ladder has come to."""

    def __init__(self, tell: Progress, keep: Callable[[LawFile], None], say: Progress = silent) -> None:
        """Begin at the foot.

        Args:
            tell: is told what is being done.
            keep: is given each law that is better than those before it, so that whatever stops the ladder leaves it.
            say: is told each rung that was taken, in a line.
        """
        self._tell, self._keep, self._say = tell, keep, say
        self._laws: list[tuple[LawFile, tuple[Rung, ...]]] = []
        self._began = time.monotonic()

    def come(self, law: LawFile, ladder: tuple[Rung, ...]) -> None:
        """Note a law that a rung has come to, with what was done on the way; keep it where it is the best so far."""
        before = self._laws[-1][1] if self._laws else ()
        shared = sum(1 for _ in takewhile(lambda pair: pair[0] is pair[1], zip(before, ladder, strict=False)))
        self._laws.append((law, ladder))
        if self.best is law:
            self._keep(law)
        way = "another way, " if shared < len(before) else ""
        took = f"{time.monotonic() - self._began:.0f} s"
        for number, rung in enumerate(ladder[shared:], shared + 1):
            self._say(f"{took}: {way}rung {number}: {rung.said()}")

    def doing(self, what: str) -> None:
        """Tell what is being done, and how far the ladder has come."""
        self._tell(f"{_fall(self._laws[-1][1])}; {what}" if self._laws else what)

    @property
    def best(self) -> LawFile | None:
        """The law with the least error on left-out conditions; None where no rung was climbed."""
        return min(self._laws, key=_error)[0] if self._laws else None

    @property
    def steps(self) -> str:
        """What was done on the way to the last law; empty where no rung was climbed."""
        return " ".join(str(rung.change.step) for rung in self._laws[-1][1]) if self._laws else ""

    def words(self) -> str:
        """Say what the best law did to the error on left-out conditions."""
        return _fall(min(self._laws, key=_error)[1])


def _error(law: tuple[LawFile, tuple[Rung, ...]]) -> float:
    return law[1][-1].change.heldout.after


def _fall(ladder: tuple[Rung, ...]) -> str:
    errors = error_goes(ladder[0].change.heldout.before, ladder[-1].change.heldout.after)
    return f"{errors} on left-out conditions"
