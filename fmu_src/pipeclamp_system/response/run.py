"""Following the response of a described system, and co-simulating it on its curves."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_system.cosim.building import finished, law_in
from pipeclamp_system.cosim.static_stability import about_rest
from pipeclamp_system.description.system import ResponseTable, SystemDescription
from pipeclamp_system.response.curves import Curve, FrequencyResponse, label
from pipeclamp_system.response.dots import Dot, Rest, co_simulated
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.described import ranges_of, read_responding, steady_system
from pipeclamp_system.steady.detached import detached_branches, leaving_branches
from pipeclamp_system.steady.states import FollowedResponse, SteadyState, Unsteady, amplitudes_of

SEARCH_TIMES, LEAST_SEARCH, MOST_SEARCH = 4.0, 1.5e6, 8e6
"""Times the work of the curve itself that may be done to seek further branches, the least that may be, and the most of
all: some minutes."""

AMOUNTS = {
    "acceleration_m_s2": "acceleration {:g} m/s²",
    "displacement_mm": "displacement {:g} mm",
    "force_N": "force {:g} N",
}
"""What shakes the pipe at level 1, in words, by the key of a system's excitation."""


def run_response(path: Path, progress: Progress = silent, *, dots: bool = True) -> FrequencyResponse:
    """Give the frequency response of the system that a file describes.

    Args:
        path: SYSTEM.toml; paths in it are relative to its folder.
        progress: told what is being done.
        dots: whether it is co-simulated too, as often as the file asks for.

    Raises:
        UserError: the system can't be read or built, has no sine, no law or nothing to show, or a co-simulation fails.
    """
    asked = read_responding(path)
    description, table, pipe = asked.description, asked.table, asked.pipe
    curves: list[Curve] = []
    found: list[Dot] = []
    leaves_rest: list[str] = []
    frequencies = _dot_frequencies(table) if dots else ()
    with finished(description, path.parent) if frequencies else nullcontext(description) as ready:
        for temperature in table.temperatures_C or (None,):
            leaves_rest.append(about_rest(_at_temperature(description, temperature), path.parent, str(path)))
            for level in table.levels:
                progress(label(temperature, level))
                place = str(path)
                system = steady_system(description, pipe, path.parent, temperature, level, table.harmonics, place)

                def tell(what: str, where: str = label(temperature, level)) -> None:
                    progress(f"{where}, {what}")

                curve = curve_of(system, table, temperature, level, place, tell)
                curves.append(curve)
                for frequency in frequencies:
                    progress(f"{label(temperature, level)}, co-simulation at {frequency:.4g} Hz")
                    passed = [state for piece in curve.pieces for state in system.crossings(piece, frequency)]
                    passed += _marched_at(system, curve.followed, frequency)
                    stable = [
                        Rest(amplitudes_of(state), -state.growth, state.truncated) for state in passed if state.stable
                    ]
                    found.append(co_simulated(ready, temperature, level, frequency, stable, path))
    excitation = description.excitation
    amount = excitation.model_dump(include={"acceleration_m_s2", "displacement_mm", "force_N"}, exclude_none=True)
    return FrequencyResponse(
        description.name,
        tuple(clamp.at for clamp in description.clamps),
        pipe.probe_names,
        ", ".join(AMOUNTS[name].format(value) for name, value in amount.items()),
        tuple(curves),
        tuple(found),
        tuple(ranges_of(law_in(path.parent, str(clamp.law))) for clamp in description.clamps),
        table.harmonics is not None,
        tuple(dict.fromkeys(words for words in leaves_rest if words)),
    )


def _at_temperature(description: SystemDescription, temperature: float | None) -> SystemDescription:
    """Give a system with all its clamps at a temperature, degC; None for their own."""
    if temperature is None:
        return description
    clamps = tuple(clamp.model_copy(update={"temperature_C": temperature}) for clamp in description.clamps)
    return description.model_copy(update={"clamps": clamps})


def _marched_at(system: SteadySystem, followed: FollowedResponse, frequency: float) -> list[SteadyState]:
    """Give the steady states at a frequency (Hz) among those that were found in time."""
    passed = [way for way in followed.in_time if way[0].frequency <= frequency <= way[-1].frequency]
    marched = [system.marched(frequency)] if passed else []
    found = [system.state_in_time(one) for one in marched if one is not None and one.round == 1]
    return found + [min(way, key=lambda state: abs(state.frequency - frequency)) for way in passed[1:]]


def curve_of(
    system: SteadySystem, table: ResponseTable, temperature: float | None, level: float, where: str,
    tell: Progress = silent,
) -> Curve:  # fmt: skip
    """Follow one curve, and seek what is detached from it.

    Raises:
        UserError: no steady state is found.
    """
    followed = system.followed(table.from_Hz, table.to_Hz, tell)
    if not followed.states:
        raise UserError(
            f"{where}: {label(temperature, level)}: no steady state is found from {table.from_Hz:g} to "
            f"{table.to_Hz:g} Hz{_at_most(followed.unsteady)}; run its sines in time by `pipeclamp cosim`"
        )
    if followed.in_time:  # a branch apart begins in the balance, which gives none there
        return Curve(temperature, level, followed)
    first, last = table.from_Hz, table.to_Hz
    with system.work.at_most(float(np.clip(SEARCH_TIMES * system.work.done, LEAST_SEARCH, MOST_SEARCH))):
        if followed.unbounded:  # without damping there is no end of branches: only those between resonances are sought
            detached = detached_branches(system, followed.pieces, first, last, over_levels=False, tell=tell)
            return Curve(temperature, level, followed, detached, sought_whole=not system.work.used_up)
        tell("branches that leave it")
        leaving = leaving_branches(system, followed.pieces, first, last)
        detached = detached_branches(system, followed.pieces, first, last, leaving, tell=tell)
        leaving += leaving_branches(system, detached, first, last)
        return Curve(temperature, level, followed, detached, leaving, sought_whole=not system.work.used_up)


def _at_most(unsteady: Sequence[Unsteady]) -> str:
    """Say how far motions go that don't repeat."""
    if not unsteady:
        return ""
    return f": no motion repeats, and they go as far as {max(max(one.high) for one in unsteady):.3g} mm"


def _dot_frequencies(table: ResponseTable) -> Sequence[float]:
    """Give frequencies inside the range, evenly spread."""
    return np.linspace(table.from_Hz, table.to_Hz, table.dots + 2)[1:-1].tolist() if table.dots else ()
