"""What a clamp's native FMU is made of: the variables of the Python FMU, and those that show its memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from pipeclamp_fmu.contents.clamp import (
    BETWEEN,
    COEFFICIENTS,
    clamp_documentation,
    clamp_extras,
    clamp_text,
    clamp_variables,
    quantities,
)
from pipeclamp_fmu.contents.clamp_dependencies import clamp_dependencies
from pipeclamp_fmu.contents.clamp_model import ClampModel, Entry
from pipeclamp_fmu.contents.continuous_memory import parts_of_step
from pipeclamp_fmu.describe.model_description import Quantity
from pipeclamp_fmu.describe.variables import Variable
from pipeclamp_fmu.native.description import FLANGE, Terminal
from pipeclamp_fmu.native.packing import NativeContent
from pipeclamp_fmu.native.sources import NativeModel
from pipeclamp_fmu.slaves import clamp as clamp_slave

MEMORY = "memory."
"""What the names of the variables begin with that hold the clamp's memory."""

DISSIPATED = "dissipated"
"""Of these, the state that integrates the dissipated energy."""

SOURCES = ("clamp.c", "clamp.h", "clamp_slopes.c", "own_motion.c", "within_step.c")
IN_STEPS = ("memory_in_steps.c", "no_states.c")
AS_STATES = ("memory_as_states.c",)
"""The clamp's C sources, and those of how its memory moves on in model exchange."""


def native_clamp(model: ClampModel, source: str, states: Sequence[Entry], version: str) -> NativeContent:
    """Give all that goes into the clamp's native FMU.

    Args:
        model: the law.
        source: the law in C, see `pipeclamp_models.realise.c.c_source`.
        states: of its memory.
        version: of this program.
    """
    described = quantities(model)
    variables = clamp_variables(model, described)
    as_states = model.start.memory_as_states
    icon, references = clamp_extras(model, variables, model_exchange=not as_states)
    shown = _continuous(described, states) if as_states else ()
    return NativeContent(
        kind="clamp",
        text=clamp_text(model, version),
        model=NativeModel(
            model.name,
            (*SOURCES, *(AS_STATES if as_states else IN_STEPS)),
            {"law.h": _header(model, source)},
            replace(
                variables, locals=(*shown, *_memory(described, () if as_states else states)), states=len(shown) // 2
            ),
            model.ranges,
            f"{MEMORY}v" if states and model.start.events else "",
            steps_matter=not as_states,
            exchange_slopes=not as_states,
        ),
        terminals=(
            Terminal(
                "flange",
                FLANGE,
                {"s": ("flange.s", "signal"), "v": ("flange.v", "signal"), "f": ("flange.f", "inflow")},
            ),
        ),
        dependencies=clamp_dependencies(
            model.source,
            variables,
            [entry.name for entry in model.further],
            [variable.name for variable in shown[: len(shown) // 2]],
        ),
        documentation=clamp_documentation(model, described, _use(model, bool(states))),
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
            f'#define STATES_SOURCE "{(AS_STATES if model.start.memory_as_states else IN_STEPS)[0]}"',
            "",
            source,
            "/* Conditions: the law's unit in the FMU's, whether they must be above 0, which counts load cycles. */",
            f"static const double CONDITION_SCALES[] = {{{scales}}};",
            f"static const int CONDITION_POSITIVE[] = {{{positive}}};",
            f"enum {{ COUNTED = {counted} }};",
            "",
            "/* In how many parts a step is walked. */",
            f"enum {{ PARTS = {parts_of_step(model)} }};",
            "",
        ]
    )


def _memory(described: Mapping[str, Quantity], states: Sequence[Entry]) -> tuple[Variable, ...]:
    """Give the variables that show the clamp's memory."""
    s, v = (replace(described[f"flange.{letter}"], minimum=None, maximum=None) for letter in "sv")
    kept = "at the end of the last step (model exchange: at the present time)"
    return (
        Variable(f"{MEMORY}s", replace(s, description=f"displacement {kept}")),
        Variable(f"{MEMORY}v", replace(v, description=f"velocity {kept}; where it changes sign, memory turns round")),
        *(Variable(f"{MEMORY}{state.name}", Quantity(f"{state.meaning} {kept}", state.unit)) for state in states),
    )


def _continuous(described: Mapping[str, Quantity], states: Sequence[Entry]) -> tuple[Variable, ...]:
    """Give the continuous states in the order in which memory_as_states.c has them, then their derivatives."""
    force, s = (described[name].nominal or 1.0 for name in ("flange.f", "flange.s"))
    sizes = {"N": force, "mm": 1e3 * s}
    dissipated = replace(described["energyDissipated"], description="dissipated energy", minimum=None, maximum=None)
    listed = (
        *(
            Variable(f"{MEMORY}{entry.name}", Quantity(entry.meaning, entry.unit, nominal=sizes.get(entry.unit)))
            for entry in states
        ),
        Variable(f"{MEMORY}{DISSIPATED}", dissipated),
    )
    rates = (
        Variable(f"der({entry.name})", Quantity(f"change of the {entry.quantity.description} per second"))
        for entry in listed
    )
    return (*listed, *rates)


CO_SIMULATION = f"In co-simulation flange.s and flange.v are the values at the end of a step. {BETWEEN}"
SAVED = "States are saved, restored and serialised exactly. Standard C library only; the sources are inside."

NATIVE_USE = (
    CO_SIMULATION,
    "In model exchange the force is that of such a move from the last completed integrator step to the present "
    "inputs. There are no continuous states: memory moves on at completed integrator steps and events "
    "(memory.s and the variables beside it show it), and a reversal of the motion is an event where the law has "
    "memory. So slip is exact however long the integrator's steps are; a force that relaxes in time is exact for a "
    "displacement that is linear over a step.",
    "Directional derivatives of the outputs by inputs and tunable parameters are exact; with memory they are those of "
    "going on in the last step's direction. Of a step in which the motion turned round, and of laws "
    "with play, they are central differences.",
    COEFFICIENTS,
    SAVED,
)

WITHOUT_EVENTS = (
    *NATIVE_USE,
    "This FMU was built without events: a reversal within an integrator's step is placed by displacement and velocity "
    "at its ends, as in co-simulation.",
)

STATES_USE = (
    CO_SIMULATION,
    "This FMU was built with memory as states: in model exchange the law's memory and the dissipated energy are "
    "continuous states, and force and derivatives depend on time, inputs and states alone. So importers that complete "
    "no integrator steps get the right force; its accuracy is that of their integrator. A state's derivative is that "
    "of the law's own step along the motion, for its length towards 0.",
    "In model exchange forceDeviation is 0, for nothing looks at whole cycles, track can't be used, and there are no "
    "directional derivatives; in co-simulation those of the outputs are exact, or central differences where the motion "
    "turned round in the step.",
    COEFFICIENTS,
    SAVED,
)

WITHOUT_REVERSALS = "This FMU was built without events: an integrator finds reversals by its control of the error."


def _use(model: ClampModel, with_memory: bool) -> tuple[str, ...]:
    """Give how to use the FMU."""
    without_events = with_memory and not model.start.events
    if model.start.memory_as_states:
        return (*STATES_USE, WITHOUT_REVERSALS) if without_events else STATES_USE
    return WITHOUT_EVENTS if without_events else NATIVE_USE
