"""The C sources of a native FMU: templates from `native/`, and what is generated for a model."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources

from pipeclamp_fmu.describe.variables import DataRange, Variables
from pipeclamp_fmu.slaves.one_module import content_hash

SHARED_SOURCES = (
    "fmu.c", "export.h", "model.h", "values.h", "values.c", "instance.h", "instance.c", "variables.c", "fmi.c",
)  # fmt: skip
"""The sources that every native FMU has."""

FMI_SOURCES: Mapping[int, tuple[str, ...]] = {2: ("fmi2.h", "fmi2.c"), 3: ("fmi3.h", "fmi3.c")}


@dataclass(frozen=True)
class NativeModel:
    """A model in C.

    Attributes:
        name: the name that messages use.
        sources: names of its templates in `native/`; the first is its C file.
        generated: text of its generated files by name; the templates' headers see them.
        variables: its variables.
        ranges: of its first tunable parameters.
        indicator: name of the variable whose zero crossings are events of model exchange, "" for none.
        steps_matter: whether model exchange moves something on at completed integrator steps.
        exchange_slopes: whether there are directional derivatives in model exchange, as in co-simulation.
    """

    name: str
    sources: tuple[str, ...]
    generated: Mapping[str, str]
    variables: Variables
    ranges: Sequence[DataRange]
    indicator: str = ""
    steps_matter: bool = True
    exchange_slopes: bool = True


def template(name: str) -> str:
    """Give the text of a C source of this package."""
    return resources.files("pipeclamp_fmu").joinpath("native", "c", name).read_text(encoding="utf-8")


def c_sources(model: NativeModel, fmi: int, identifier: str) -> dict[str, str]:
    """Give all C sources by file name."""
    names = (*SHARED_SOURCES, *FMI_SOURCES[fmi], *model.sources)
    return {
        **{name: template(name) for name in names},
        **model.generated,
        "layout.h": _layout(model, fmi, identifier),
    }


def _layout(model: NativeModel, fmi: int, identifier: str) -> str:
    """Give `layout.h`: which files, how many variables, and their names."""
    variables = model.variables
    counts = {
        "INPUTS": len(variables.inputs),
        "SIGNALS": variables.signals,
        "PARAMETERS": len(variables.parameters),
        "OUTPUTS": len(variables.outputs),
        "LOCALS": len(variables.locals),
        "FIXED": len(variables.fixed),
        "STATES": variables.states,
        "FLAG_PARAMETERS": len(variables.boolean_parameters),
        "FLAG_LOCALS": len(variables.boolean_locals),
        "RANGES": len(model.ranges),
        "INDICATORS": int(bool(model.indicator)),
        "EXCHANGE_SLOPES": int(model.exchange_slopes),
    }
    structure = content_hash(*model.generated.values(), *(variable.name for variable in variables.all))
    headers = [*model.generated, *(name for name in model.sources if name.endswith(".h"))]
    return "\n".join(
        [
            "/* Generated: which files this FMU consists of, and its variables. */",
            "#ifndef LAYOUT_H",
            "#define LAYOUT_H",
            "",
            f"#define FMI_VERSION {fmi}",
            f'#define MODEL_SOURCE "{model.sources[0]}"',
            f"#define FUNCTION_PREFIX {identifier}_",
            f"#define STRUCTURE 0x{structure[:16]}u /* tells its saved states from others' */",
            "",
            "#define ROOM(count) ((count) > 0 ? (count) : 1) /* C has no arrays without entries */",
            "",
            f"enum {{ {', '.join(f'{name} = {count}' for name, count in counts.items())} }};",
            "",
            _names("REAL_NAMES", [variable.name for variable in variables.reals]),
            _names("FLAG_NAMES", [variable.name for variable in variables.booleans]),
            f"static const double STATE_NOMINALS[] = {{{_nominals(variables)}}};",
            _names("RANGE_UNITS", [entry.unit for entry in model.ranges]),
            "",
            *(f'#include "{name}"' for name in headers),
            "",
            "#endif",
            "",
        ]
    )


def _nominals(variables: Variables) -> str:
    return ", ".join(repr(entry.quantity.nominal or 1.0) for entry in variables.state_variables) or "1.0"


def _names(array: str, names: Sequence[str]) -> str:
    listed = ",\n    ".join(json.dumps(name) for name in names or [""])
    return f"static const char *const {array}[] = {{\n    {listed}\n}};"
