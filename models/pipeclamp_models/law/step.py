"""A step of a law's way: effects that came, effects that went, another base; and how a file's history writes it."""

from __future__ import annotations

from dataclasses import dataclass

ADDED, REMOVED, IN_PLACE, ON_BASE, ALONE = "+ ", "- ", " -> ", "base ", " alone"
REFIT = "a refit"
AND = " and "


@dataclass(frozen=True)
class Step:
    """What was done to a law; nothing, where it was only refitted.

    Attributes:
        come: effects that came.
        gone: effects that went.
        base: the base that it was put on; empty where it stayed on its own.
        alone: whether all effects went with that.
    """

    come: tuple[str, ...] = ()
    gone: tuple[str, ...] = ()
    base: str = ""
    alone: bool = False

    @property
    def adds(self) -> bool:
        """Whether effects came and none went."""
        return bool(self.come) and not self.gone

    @property
    def effect(self) -> str:
        """What came or, where nothing did, went; empty of a base and of a refit."""
        return AND.join(self.come or self.gone)

    def __str__(self) -> str:
        """Give it as a law's history has it."""
        if self.base:
            return f"{ON_BASE}{self.base}{ALONE if self.alone else ''}"
        if self.come and self.gone:
            return f"{AND.join(self.gone)}{IN_PLACE}{AND.join(self.come)}"
        return f"{ADDED if self.come else REMOVED}{self.effect}" if self.effect else REFIT


def read_step(text: str) -> Step:
    """Give a step as a law's history has it; nothing done, for the first, which says what the law began with."""
    if text.startswith(ON_BASE):
        base = text.removeprefix(ON_BASE)
        return Step(base=base.removesuffix(ALONE), alone=base.endswith(ALONE))
    if text.startswith(ADDED):
        return Step(come=tuple(text.removeprefix(ADDED).split(AND)))
    if text.startswith(REMOVED):
        return Step(gone=tuple(text.removeprefix(REMOVED).split(AND)))
    gone, arrow, come = text.partition(IN_PLACE)
    return Step(tuple(come.split(AND)), tuple(gone.split(AND))) if arrow else Step()
