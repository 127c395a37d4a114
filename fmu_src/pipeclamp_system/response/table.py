"""A frequency response as a table, a row for each state and each co-simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import repeat
from pathlib import Path

import numpy as np

from pipeclamp_models.base.files import write_whole
from pipeclamp_models.base.tables import pl
from pipeclamp_system.response.curves import Curve, FrequencyResponse
from pipeclamp_system.steady.states import SteadyState, amplitudes_of, half_range


def write_response(
    response: FrequencyResponse, path: Path, beside: Sequence[Mapping[str, float]] | None = None
) -> None:
    """Write curves and dots as CSV, whole or not at all: `response_frame`.

    Raises:
        UserError: the folder can't be written.
    """
    write_whole(path, response_frame(response, beside).write_csv())


def response_frame(response: FrequencyResponse, beside: Sequence[Mapping[str, float]] | None = None) -> pl.DataFrame:
    """Give curves and dots, a row each, with "name [unit]" as header.

    Args:
        response: curves and dots.
        beside: further columns of each state of the curves, in their order, by header.
    """
    rows: list[dict[str, float | str | None]] = []
    further = iter(beside if beside is not None else repeat({}))
    for curve in response.curves:
        for number, state in ((n, state) for n, piece in enumerate(curve.pieces, 1) for state in piece):
            row = _state_row("curve", curve, state, response)
            rows.append({**row, "piece": number, "harmonics": state.harmonics, **next(further)})
        rows += [
            {**_state_row("in time", curve, state, response), "piece": number, "cycles": state.cycles}
            for number, way in enumerate(curve.followed.in_time, len(curve.pieces) + 1)
            for state in way
        ]
        for one in curve.followed.unsteady:
            row = _row("in time, unsteady", curve.temperature, curve.level, one.frequency, one.high, response)
            row |= {f"{name}.s_least [mm]": low for name, low in zip(response.points, one.low, strict=True)}
            rows.append({**row, "repeats": 0.0, "cycles": one.cycles, "comes round in [cycles]": one.round or None})
    for dot in response.dots:
        row = _row("co-simulation", dot.temperature, dot.level, dot.frequency, dot.amplitudes, response)
        row |= {"settled": float(dot.settled), "trusted": float(dot.trusted), "repeats": float(dot.repeats)}
        row |= {"step [s]": dot.step}
        rows.append(row | {"truncated [1]": dot.truncated})
    return pl.from_dicts(rows, infer_schema_length=None)


def _state_row(
    kind: str, curve: Curve, state: SteadyState, response: FrequencyResponse
) -> dict[str, float | str | None]:
    row = _row(kind, curve.temperature, curve.level, state.frequency, amplitudes_of(state), response)
    row |= {
        "stable": None if state.neutral else float(state.stable),
        "growth [1/s]": state.growth,
        "truncated [1]": state.truncated,
    }
    means = np.concatenate([state.clamps[:, 0].real, state.probes[:, 0].real])
    row |= {f"{name}.mean [mm]": mean for name, mean in zip(response.points, means.tolist(), strict=True)}
    for name, (amplitude, frequency), force, beyond in zip(
        response.clamp_names, state.conditions.tolist(), half_range(state.forces).tolist(), state.beyond, strict=True
    ):
        row |= {f"{name}.A_used [mm]": amplitude, f"{name}.f_used [Hz]": frequency, f"{name}.f [N]": force}
        row[f"{name}.inRange [1 yes, 0 no]"] = float(not beyond)
    return row


def _row(
    kind: str, temperature: float | None, level: float, frequency: float, amplitudes: Sequence[float],
    response: FrequencyResponse,
) -> dict[str, float | str | None]:  # fmt: skip
    row: dict[str, float | str | None] = {
        "kind": kind,
        "temperature [degC]": temperature,
        "level": level,
        "frequency [Hz]": frequency,
    }
    return row | {f"{name}.s [mm]": value for name, value in zip(response.points, amplitudes, strict=True)}
