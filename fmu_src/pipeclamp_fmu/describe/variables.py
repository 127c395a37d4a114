"""The variables of an FMU, in the order in which its program holds them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from pipeclamp_fmu.describe.model_description import Quantity
from pipeclamp_fmu.slaves.values_file import TOLD


@dataclass(frozen=True)
class Variable:
    """A variable of a model.

    Attributes:
        name: as importers see it.
        quantity: what a person and an importer should know of it.
        start: value of an input or a parameter at the start; None for what is calculated.
        asked: whether that value was asked for, and isn't the usual one.
    """

    name: str
    quantity: Quantity
    start: float | bool | None = None
    asked: bool = False


@dataclass(frozen=True)
class DataRange:
    """Where a quantity lay in the data, in the law's unit."""

    minimum: float
    maximum: float
    unit: str


@dataclass(frozen=True)
class Variables:
    """All variables by what they are; value references count through them in this order, from 1.

    Attributes:
        inputs, parameters, outputs, locals, fixed: of type Real; `parameters` are tunable.
        boolean_parameters, boolean_locals: of type Boolean.
        states: how many of the locals, the first, are continuous states; as many after them are their derivatives.
        unconnected: how many of the inputs, the last, aren't to be connected, and are tunable parameters for importers.
        signals: how many of the inputs may change with every step without unsettling the conditions.
    """

    inputs: tuple[Variable, ...]
    parameters: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    locals: tuple[Variable, ...]
    fixed: tuple[Variable, ...]
    boolean_parameters: tuple[Variable, ...]
    boolean_locals: tuple[Variable, ...]
    signals: int
    states: int = 0
    unconnected: int = 0

    @property
    def state_variables(self) -> tuple[Variable, ...]:
        """The continuous states."""
        return self.locals[: self.states]

    @property
    def connected(self) -> tuple[Variable, ...]:
        """The inputs that are inputs for importers too."""
        return self.inputs[: len(self.inputs) - self.unconnected]

    @property
    def derivatives(self) -> tuple[Variable, ...]:
        """Their derivatives, in the same order."""
        return self.locals[self.states : 2 * self.states]

    @property
    def reals(self) -> tuple[Variable, ...]:
        """The variables of type Real."""
        return (*self.inputs, *self.parameters, *self.outputs, *self.locals, *self.fixed)

    @property
    def booleans(self) -> tuple[Variable, ...]:
        """The variables of type Boolean."""
        return (*self.boolean_parameters, *self.boolean_locals)

    @property
    def all(self) -> tuple[Variable, ...]:
        """All variables, in the order of their value references."""
        return (*self.reals, *self.booleans)

    def causality(self, variable: Variable) -> tuple[str, str]:
        """Give a variable's causality and variability."""
        groups: Sequence[tuple[tuple[Variable, ...], str, str]] = (
            (self.connected, "input", "continuous"),
            ((*self.inputs, *self.parameters, *self.boolean_parameters), "parameter", "tunable"),
            (self.outputs, "output", "continuous"),
            (self.locals, "local", "continuous"),
            (self.boolean_locals, "local", "discrete"),
            (self.fixed, "parameter", "fixed"),
        )
        return next((causality, variability) for group, causality, variability in groups if variable in group)


TIME = "time"
"""The independent variable's name among dependencies."""


@dataclass(frozen=True)
class Dependencies:
    """What outputs and states' derivatives depend on, by name; what isn't listed depends on nothing.

    Attributes:
        always: on which inputs and states at the same time, and on TIME.
        initially: on which inputs and parameters at initialisation.
    """

    always: Mapping[str, Sequence[str]] = field(default_factory=dict)
    initially: Mapping[str, Sequence[str]] = field(default_factory=dict)


def numbers_of(variables: Variables, ranges: Sequence[DataRange]) -> list[tuple[str, float, str]]:
    """Give what the file of values says: name, value and unit of each start value and each end of a range."""
    started = (*variables.inputs, *variables.parameters, *variables.fixed, *variables.boolean_parameters)
    numbers = [
        (entry.name, float(entry.start or 0.0), f"{entry.quantity.unit} {TOLD if entry.asked else ''}".strip())
        for entry in started
    ]
    for entry in ranges:
        numbers += [("minimum", entry.minimum, entry.unit), ("maximum", entry.maximum, entry.unit)]
    return numbers
