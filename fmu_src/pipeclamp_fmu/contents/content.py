"""What an FMU is made of, whatever its kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import pythonfmu

from pipeclamp_fmu.describe.model_description import ModelText, Quantity
from pipeclamp_fmu.slaves.one_module import content_hash


@dataclass(frozen=True)
class Content:
    """What an FMU is made of.

    Attributes:
        kind: "clamp" or "pipe", the start of the names of module, class and library.
        source: the slave's module, in one file.
        class_name: name of the slave's class in it.
        text: what the description says of the whole.
        quantities: what it says of each variable.
        initially: the variables that each output depends on at initialisation, if it does.
        documentation: `documentation/index.html`.
        further: further files by name.
        name: the name that messages use.
        numbers: what the slave reads of its file of values, see `values_text`; nothing where it has none.
        tunable: inputs of the slave that are tunable parameters for importers.
    """

    kind: str
    source: str
    class_name: str
    text: ModelText
    quantities: Mapping[str, Quantity]
    initially: Mapping[str, Sequence[str]]
    documentation: str
    further: Mapping[str, bytes] = field(default_factory=dict)
    name: str = ""
    numbers: Sequence[tuple[str, float, str]] = ()
    tunable: tuple[str, ...] = ()

    @property
    def identifier(self) -> str:
        """The name of module, class and library: unique for the program."""
        return f"{self.kind}_{content_hash(self.source, str(pythonfmu.__version__))[:16]}"

    @property
    def starts(self) -> dict[str, float]:
        """The start values that the slave reads, by variable."""
        return {name: value for name, value, _ in self.numbers if name in self.quantities}

    @property
    def module(self) -> str:
        """The slave's module, its class under the identifier."""
        return self.source.replace(self.class_name, self.identifier)
