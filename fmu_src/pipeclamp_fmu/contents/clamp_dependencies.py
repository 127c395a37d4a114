"""What a clamp's outputs depend on, for importers that look for algebraic loops or for the pattern of the Jacobian."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Sequence

from pipeclamp_fmu.describe.variables import TIME, Dependencies, Variables


def clamp_dependencies(
    source: str, variables: Variables, further: Iterable[str], states: Sequence[str] = ()
) -> Dependencies:
    """Give what the clamp's outputs depend on.

    A and f may be tracked, whenever `track` is set: then the motion and the time since the last step move them.

    Args:
        source: the law's, see `pipeclamp_models.realise.scalar.python_source`.
        variables: of the clamp.
        further: names of the parameters that state further conditions.
        states: names of the continuous states; the last is the dissipated energy.
    """
    read = _read(source)
    connected = [variable.name for variable in variables.connected]
    temperature = [name for name in ("T_in",) if name in connected]
    motion = [name for name in connected if name.startswith("flange.")]
    told = [name for name in ("A", "f") if name in read]
    force = [*motion, *(temperature if "T" in read else ()), *([TIME] if told or "h" in read else ())]
    settings = [*told, *(["track"] if told else ()), *(["T", "T_in", "useTemperatureInput"] if "T" in read else ())]
    memory = states[:-1]
    known = (*motion, *settings, *further, *(variable.name for variable in variables.fixed))
    rates = {f"der({name})": (*force, *memory) for name in states}
    return Dependencies(
        always={
            **rates,
            "flange.f": (*force, *memory),
            "A_used": ("flange.s", TIME),
            "f_used": (*motion, TIME),
            "T_used": tuple(temperature),
            "energyDissipated": tuple(states[-1:] or force),
            "forceDeviation": tuple(force) if told else (),
        },
        initially={
            "flange.f": known,
            **dict.fromkeys(rates, known),
            "A_used": ("A", "track"),
            "f_used": ("f", "track"),
            "T_used": ("T", "T_in", "useTemperatureInput"),
        },
    )


def _read(source: str) -> set[str]:
    """Give the names that a law's source reads."""
    nodes = ast.walk(ast.parse(source))
    return {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
