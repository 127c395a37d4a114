"""A step of a law's way: effects that came or went, another base, what is held; and how a file's history writes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

_ADDED, _REMOVED, _IN_PLACE, _ON_BASE, _ALONE = "+ ", "- ", " -> ", "base ", " alone"
_HELD, _FREED = "without ", "with "
_REFIT = "a refit"
_AND = " and "


class BeforeAfter(NamedTuple):
    """A law's error before a step and after it, as a share of the force."""

    before: float
    after: float


@dataclass(frozen=True)
class LawStep:
    """What was done to a law; nothing, where it was only refitted.

    Attributes:
        come: effects that came.
        gone: effects that went.
        base: the base that it was put on; empty where it stayed on its own.
        alone: whether all effects went with that.
        held: parameters of its base that are held where they do nothing from then on.
        freed: parameters of its base that were held so, and are fitted from then on.
    """

    come: tuple[str, ...] = ()
    gone: tuple[str, ...] = ()
    base: str = ""
    alone: bool = False
    held: tuple[str, ...] = ()
    freed: tuple[str, ...] = ()

    @property
    def adds(self) -> bool:
        """Whether effects came and none went."""
        return bool(self.come) and not self.gone

    @property
    def effect(self) -> str:
        """What came or, where nothing did, went; empty of a base and of a refit."""
        return _AND.join(self.come or self.gone)

    def __str__(self) -> str:
        """Give it as a law's history has it."""
        if self.base:
            return f"{_ON_BASE}{self.base}{_ALONE if self.alone else ''}"
        if self.held:
            return f"{_HELD}{_AND.join(self.held)}"
        if self.freed:
            return f"{_FREED}{_AND.join(self.freed)}"
        if self.come and self.gone:
            return f"{_AND.join(self.gone)}{_IN_PLACE}{_AND.join(self.come)}"
        return f"{_ADDED if self.come else _REMOVED}{self.effect}" if self.effect else _REFIT


def read_step(text: str) -> LawStep:
    """Give a step as a law's history has it; nothing done, for the first, which says what the law began with."""
    if text.startswith(_ON_BASE):
        base = text.removeprefix(_ON_BASE)
        return LawStep(base=base.removesuffix(_ALONE), alone=base.endswith(_ALONE))
    if text.startswith(_HELD):
        return LawStep(held=tuple(text.removeprefix(_HELD).split(_AND)))
    if text.startswith(_FREED):
        return LawStep(freed=tuple(text.removeprefix(_FREED).split(_AND)))
    if text.startswith(_ADDED):
        return LawStep(come=tuple(text.removeprefix(_ADDED).split(_AND)))
    if text.startswith(_REMOVED):
        return LawStep(gone=tuple(text.removeprefix(_REMOVED).split(_AND)))
    gone, arrow, come = text.partition(_IN_PLACE)
    return LawStep(tuple(come.split(_AND)), tuple(gone.split(_AND))) if arrow else LawStep()
