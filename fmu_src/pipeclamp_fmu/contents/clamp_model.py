"""A clamp's law as its FMU takes it: source, values, conditions, and what it starts from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipeclamp_fmu.contents.behind import Behind
from pipeclamp_fmu.contents.passivity import Interval
from pipeclamp_fmu.describe.variables import DataRange
from pipeclamp_models.base.digits import plain
from pipeclamp_models.equations.symbols import REFERENCES, T_0
from pipeclamp_models.law.file import FitQuality, HistoryStep
from pipeclamp_models.realise.scalar_law import ScalarLaw, loaded

TEMPERATURE_BOUNDS = (1.0, 2000.0)
"""min and max of temperatures, K: above absolute zero, and above what any steel stands."""


@dataclass(frozen=True)
class FurtherCondition:
    """A slow signal of the law besides A, f and T, as a parameter of the FMU.

    Attributes:
        name: of the parameter.
        meaning: one phrase.
        unit: the FMU's, "" where only the column's name tells it.
        display_unit: the unit for people, "" for the same.
        law_unit: the law's.
        scale: a value in the law's unit over the one in the FMU's.
        interval: what the law's data hold, in the law's unit.
        positive: whether it must be above 0.
        start: in the FMU's unit.
        counted: whether the clamp's own load cycles are added to it.
    """

    name: str
    meaning: str
    unit: str
    display_unit: str
    law_unit: str
    scale: float
    interval: Interval
    positive: bool
    start: float
    counted: bool = False

    def words(self) -> str:
        """Say at which value it stands until it is set, and what the law's tests hold, in the FMU's unit."""
        low, high = (plain(end / self.scale, 3) for end in self.interval)
        unit = f" {self.unit}" if self.unit not in ("", "1") else ""
        return f"{self.name} is {plain(self.start, 3)}{unit} until it is set (the law's tests: {low} to {high})"


@dataclass(frozen=True)
class Entry:
    """A coefficient of the law or a state of its memory, with the coefficient's value."""

    name: str
    unit: str
    meaning: str
    value: float = 0.0


@dataclass(frozen=True)
class ClampStart:
    """What a clamp FMU is told of its use when it is built; None for the middle of the law's range.

    Attributes:
        A: amplitude of the motion, m.
        f: its frequency, Hz.
        T: temperature of the clamp, K.
        track: whether A and f are followed from the motion.
        connected_temperature: whether T_in is an input, to be connected, and used.
        events: whether reversals are events of model exchange, where the law has memory.
        memory_as_states: whether memory is continuous states in model exchange, and needs no completed steps.
    """

    A: float | None = None
    f: float | None = None
    T: float | None = None
    track: bool = False
    connected_temperature: bool = False
    events: bool = True
    memory_as_states: bool = False


USUAL = ClampStart()
"""Of a clamp that is told nothing."""


@dataclass(frozen=True)
class ClampModel:
    """A law as the clamp FMU needs it.

    Attributes:
        name: the law's name.
        source: its generated source, see `pipeclamp_models.realise.scalar.python_source`.
        coefficients: in the order in which the source takes them.
        range_A: amplitudes that its data hold, mm.
        range_f: frequencies, Hz.
        range_T: temperatures, K; None where they aren't known and the law is for any.
        equations: for the documentation, one line each.
        parameters: for the documentation: symbol, value, standard error, unit, meaning.
        notes: for the documentation: what else to say of the law, its data and its quality.
        further: conditions besides A, f and T, in the order in which the source takes them.
        history, fit: for the documentation: the error step by step, and how well the law fits.
        start: what the FMU starts with.
        behind: what is known of the law's uncertainty and origin.
        about: displacement about which its tests moved, mm; 0 where that is about zero.
    """

    name: str
    source: str
    coefficients: tuple[Entry, ...]
    range_A: Interval
    range_f: Interval
    range_T: Interval | None
    equations: Sequence[str] = ()
    parameters: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()
    further: tuple[FurtherCondition, ...] = ()
    history: Sequence[HistoryStep] = ()
    fit: FitQuality | None = None
    start: ClampStart = USUAL
    behind: Behind | None = None
    about: float = 0.0

    @property
    def ranges(self) -> tuple[DataRange, ...]:
        """The ranges of all conditions, in the law's units."""
        return (
            DataRange(*self.range_A, "mm"),
            DataRange(*self.range_f, "Hz"),
            DataRange(*self.temperatures, "K"),
            *(DataRange(*entry.interval, entry.law_unit) for entry in self.further),
        )

    @property
    def temperatures(self) -> Interval:
        """The temperatures at which the law may be used, K: all, where it was identified without any."""
        return self.range_T or TEMPERATURE_BOUNDS

    @property
    def temperature(self) -> float:
        """The temperature that the clamp has unless it is told another, K."""
        return middle(self.range_T) if self.range_T else float(REFERENCES[T_0])

    @property
    def law(self) -> ScalarLaw:
        """The law, ready to be called."""
        return loaded(self.source, [entry.value for entry in self.coefficients])

    @property
    def condition_names(self) -> tuple[str, ...]:
        """The names of the parameters that state conditions, in the order in which the source takes them."""
        return ("A", "f", "T", *(entry.name for entry in self.further))

    @property
    def counted(self) -> int:
        """The place of the load cycles among the further conditions, -1 for none."""
        return next((place for place, entry in enumerate(self.further) if entry.counted), -1)


def middle(interval: Interval) -> float:
    """Give the middle of a range."""
    return (interval[0] + interval[1]) / 2
