"""What a clamp's native FMU is made of: the same variables as the Python FMU's, and the law's coefficients."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from pipeclamp_fmu import clamp_slave
from pipeclamp_fmu.clamp import ClampModel, clamp_documentation, clamp_extras, clamp_text, quantities
from pipeclamp_fmu.model_description import Quantity
from pipeclamp_fmu.native_description import FLANGE, Terminal
from pipeclamp_fmu.native_fmu import NativeContent
from pipeclamp_fmu.native_sources import NativeModel, Range
from pipeclamp_fmu.variables import Variable, Variables

COEFFICIENT = "law."
"""What the names of the law's coefficients begin with."""

MEMORY = "memory."
"""What the names of the variables begin with that hold the clamp's memory."""


@dataclass(frozen=True)
class Entry:
    """A coefficient of the law or a state of its memory, with the coefficient's value."""

    name: str
    unit: str
    meaning: str
    value: float = 0.0


@dataclass(frozen=True)
class NativeLaw:
    """A law in C, see `pipeclamp.realise.c.c_source`, with its coefficients in the order of its parameters."""

    source: str
    coefficients: tuple[Entry, ...]
    states: tuple[Entry, ...]


def native_clamp(model: ClampModel, law: NativeLaw, version: str) -> NativeContent:
    """Give all that goes into the clamp's native FMU."""
    described = quantities(model)
    icon, references = clamp_extras(model)
    variables = _variables(model, law, described)
    indicator = f"{MEMORY}v" if law.states else ""
    ranges = [
        Range(*interval, unit)
        for interval, unit in zip(
            model.ranges, ("mm", "Hz", "K", *(entry.law_unit for entry in model.further)), strict=True
        )
    ]
    return NativeContent(
        kind="clamp",
        text=clamp_text(model, version),
        model=NativeModel(
            model.name, ("clamp.c", "clamp.h"), {"law.h": _header(model, law.source)}, variables, ranges, indicator
        ),
        terminals=(
            Terminal(
                "flange",
                FLANGE,
                {"s": ("flange.s", "signal"), "v": ("flange.v", "signal"), "f": ("flange.f", "inflow")},
            ),
        ),
        documentation=clamp_documentation(model, described, NATIVE_USE),
        icon=icon,
        further=references,
    )


def _header(model: ClampModel, source: str) -> str:
    """Give `law.h`: the law's equations, and how its conditions are to be taken."""
    scales = ", ".join(repr(scale) for scale in (clamp_slave.MM, 1.0, 1.0, *(entry.scale for entry in model.further)))
    positive = ", ".join(["1", "1", "1", *(str(int(entry.positive)) for entry in model.further)])
    counted = len(model.ranges) - len(model.further) + model.counted if model.counted >= 0 else -1
    return "\n".join(
        [
            "/* Generated: the law's equations. */",
            "#include <math.h>",
            "",
            source,
            "/* Conditions: the law's unit in the FMU's, whether they must be above 0, which counts load cycles. */",
            f"static const double CONDITION_SCALES[] = {{{scales}}};",
            f"static const int CONDITION_POSITIVE[] = {{{positive}}};",
            f"enum {{ COUNTED = {counted} }};",
            "",
        ]
    )


def _variables(model: ClampModel, law: NativeLaw, described: Mapping[str, Quantity]) -> Variables:
    starts: dict[str, float | bool] = {
        "flange.s": 0.0,
        "flange.v": 0.0,
        "T_in": clamp_slave.middle(model.range_T),
        "A": clamp_slave.middle(model.range_A) / clamp_slave.MM,
        "f": clamp_slave.middle(model.range_f),
        "T": clamp_slave.middle(model.range_T),
        **{entry.name: entry.start for entry in model.further},
        **dict.fromkeys(clamp_slave.BOOLEAN_PARAMETERS, False),
    }

    def known(names: tuple[str, ...]) -> tuple[Variable, ...]:
        return tuple(Variable(name, described[name], starts.get(name)) for name in names)

    s, v = (replace(described[f"flange.{letter}"], minimum=None, maximum=None) for letter in "sv")
    kept = "at the end of the last step (model exchange: at the present time)"
    memory = [
        Variable(f"{MEMORY}s", replace(s, description=f"displacement {kept}")),
        Variable(f"{MEMORY}v", replace(v, description=f"velocity {kept}; where it changes sign, memory turns round")),
        *(Variable(f"{MEMORY}{state.name}", Quantity(f"{state.meaning} {kept}", state.unit)) for state in law.states),
    ]
    coefficients = [
        Variable(
            f"{COEFFICIENT}{entry.name}",
            Quantity(f"coefficient of the law: {entry.meaning}", entry.unit.replace("-", "")),
            entry.value,
        )
        for entry in law.coefficients
    ]
    return Variables(
        inputs=known(clamp_slave.INPUTS),
        parameters=known((*clamp_slave.PARAMETERS, *(entry.name for entry in model.further))),
        outputs=known(clamp_slave.OUTPUTS),
        locals=tuple(memory),
        fixed=tuple(coefficients),
        boolean_parameters=known(clamp_slave.BOOLEAN_PARAMETERS),
        boolean_outputs=known(clamp_slave.BOOLEAN_OUTPUTS),
        signals=clamp_slave.T_IN,
    )


NATIVE_USE = (
    "In co-simulation flange.s and flange.v are the values at the end of a step; from the last communication point to "
    "them the motion is straight. A master that steps all models in parallel therefore sees the force one step late.",
    "In model exchange the force is that of a straight move from the last completed integrator step to the present "
    "inputs. There are no continuous states: memory moves on at completed integrator steps and events "
    "(memory.s and the variables beside it show it), and a reversal of the motion is an event where the law has "
    "memory. So slip is exact however long the integrator's steps are; a force that relaxes in time is exact for a "
    "displacement that is linear over a step.",
    "Directional derivatives of the outputs by inputs and tunable parameters are exact; with memory they are those of "
    "going on in the last step's direction.",
    "The coefficients law.* are in the law's own units and can be set before and in initialization; "
    "`pipeclamp set-parameters` puts another law's into the FMU.",
    "States are saved, restored and serialised exactly. Standard C library only; the sources are inside.",
)
