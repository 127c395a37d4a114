"""What an excitation's native FMU is made of."""

from __future__ import annotations

from pipeclamp_fmu.contents.excitation import Samples, excitation_documentation, excitation_text, signal_quantity
from pipeclamp_fmu.describe.variables import TIME, Dependencies, Variable, Variables
from pipeclamp_fmu.native.packing import NativeContent
from pipeclamp_fmu.native.sources import NativeModel


def native_excitation(samples: Samples, version: str) -> NativeContent:
    """Give all that goes into the excitation's native FMU."""
    values = ", ".join(repr(float(value)) for value in samples.values)
    header = (
        "/* Generated: the samples. */\n"
        f"enum {{ SAMPLES = {len(samples.values)} }};\n"
        f"static const double STEP = {float(samples.step)!r};\n"
        f"static const double VALUES[] = {{{values}}};\n"
    )
    variables = Variables((), (), (Variable("signal", signal_quantity(samples)),), (), (), (), (), signals=0)
    return NativeContent(
        kind="excitation",
        text=excitation_text(samples, version),
        model=NativeModel(
            "excitation",
            ("excitation.c", "excitation.h", "no_states.c", "no_warnings.c"),
            {"samples.h": header},
            variables,
            (),
        ),
        terminals=(),
        dependencies=Dependencies(always={"signal": (TIME,)}),
        documentation=excitation_documentation(samples),
        icon=b"",
    )
