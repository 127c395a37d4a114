"""What pipe and clamps say at each communication point of a run, by name; and the result that it makes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_system.cosim.energy import EnergyBalance, received_work
from pipeclamp_system.cosim.hidden_motion import hidden_share
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.variables import PipeVariables
from pipeclamp_system.coupling.march import Point
from pipeclamp_system.description.scheme import ROLLS_BACK
from pipeclamp_system.description.system import LawMode, SystemDescription
from pipeclamp_system.fmus.participant import FmuParticipant

PIPE_ENERGIES = ("energyPipe", "energyDissipated", "workExcitation", "workClamps")
"""What a pipe FMU says of its energies, J."""
CLAMP_UNITS = {"A_used": "m", "f_used": "Hz", "T_used": "K", "energyDissipated": "J", "forceDeviation": "1"}
"""What a clamp FMU says of itself, with the units."""
PROBE_UNITS = {"s": "m", "v": "m/s", "a": "m/s2"}
"""What a pipe FMU says of each probe."""

MODE_CODES: dict[LawMode, float] = {"given": 0.0, "solved": 1.0, "tracked": 2.0}
"""How a result's columns say where a law's A and f came from."""


def pipe_watched(variables: PipeVariables) -> list[str]:
    """Give the names of what is kept of a pipe FMU."""
    return [*(f"{probe}.{kind}" for probe in variables.probes for kind in PROBE_UNITS), *PIPE_ENERGIES]


class Recording:
    """Keeps what is said at each communication point.

    Attributes:
        points: the coupled quantities.
    """

    def __init__(self, pipe: FmuParticipant, clamps: Mapping[str, FmuParticipant]) -> None:
        """Begin without any; clamps by name."""
        self.points: list[Point] = []
        self._participants = [pipe, *clamps.values()]
        own = [f"{name}.{kind}" for name, clamp in clamps.items() for kind in clamp.watched_names]
        self._places = {name: place for place, name in enumerate([*pipe.watched_names, *own])}
        self._clamps = clamps
        self._in_range = dict.fromkeys(clamps, True)
        self._rows: list[list[float]] = []

    def take(self, point: Point) -> None:
        """Keep a point, and what pipe and clamps say there."""
        self.points.append(point)
        self._rows.append([value for participant in self._participants for value in participant.watched()])
        for name, clamp in self._clamps.items():
            self._in_range[name] = self._in_range[name] and all(clamp.flags())

    def last(self, name: str) -> float:
        """Give what was said last of a name: NAME of the pipe, CLAMP.NAME of a clamp."""
        return self._rows[-1][self._places[name]]

    def columns(self) -> dict[str, Array]:
        """Give all that was said, by the same names, each (n,)."""
        return dict(zip(self._places, np.array(self._rows).T, strict=True))

    @property
    def out_of_range(self) -> tuple[str, ...]:
        """The clamps whose law was used beyond its data."""
        return tuple(name for name, inside in self._in_range.items() if not inside)


def recorded_result(
    system: SystemDescription, variables: PipeVariables, recording: Recording, warnings: Sequence[str]
) -> CosimResult:
    """Give the result of a run that was recorded; `system` is as it was run."""
    names = tuple(clamp.at for clamp in system.clamps)
    points, said = recording.points, recording.columns()
    columns: dict[str, Array] = {}
    units: dict[str, str] = {}

    def keep(name: str, unit: str, values: Array | list[float] | list[int]) -> None:
        columns[name], units[name] = np.asarray(values, dtype=np.float64), unit

    displacement = np.array([point.displacement for point in points])
    velocity = np.array([point.velocity for point in points])
    force = np.array([point.force for point in points])
    keep("time", "s", [point.time for point in points])
    keep(variables.excitation, "m/s2" if variables.kind == "base" else "N", [point.excitation for point in points])
    for index, name in enumerate(names):
        keep(f"{name}.s", "m", displacement[:, index])
        keep(f"{name}.v", "m/s", velocity[:, index])
        keep(f"{name}.f", "N", force[:, index])
        for kind, unit in CLAMP_UNITS.items():
            keep(f"{name}.{kind}", unit, said[f"{name}.{kind}"])
    for name, clamp in zip(names, system.clamps, strict=True):
        keep(f"{name}.law_mode", "0 given, 1 solved, 2 tracked", np.full(len(points), MODE_CODES[clamp.mode]))
    for name in variables.probes:
        for kind, unit in PROBE_UNITS.items():
            keep(f"{name}.{kind}", unit, said[f"{name}.{kind}"])
    delivered = said["workClamps"]
    if np.isnan(delivered).any():  # a foreign pipe doesn't say
        delivered = _delivered(system, points)
    heat = np.array([columns[f"{name}.energyDissipated"] for name in names])
    balance = EnergyBalance(
        excitation=said["workExcitation"],
        pipe_stored=said["energyPipe"],
        pipe_dissipated=said["energyDissipated"],
        clamps_received=_received(system, points),
        clamps_dissipated=heat.reshape(len(names), len(points)).sum(axis=0),
        delivered=delivered,
    )
    for name in balance.final():
        keep(f"energy.{name}", "J", getattr(balance, name))
    keep("trials", "1", [point.trials for point in points])
    return CosimResult(
        system=system,
        probe_names=variables.probes,
        columns=columns,
        units=units,
        energy=balance,
        out_of_range=recording.out_of_range,
        hidden_share=hidden_share(columns["time"], displacement, velocity),
        warnings=tuple(warnings),
    )


def _through(points: Sequence[Point]) -> tuple[list[Point], Array]:
    """Give the points with those that were passed within steps, and where among them the steps end."""
    whole = [one for point in points for one in (*point.passed, point)]
    return whole, np.cumsum([1 + len(point.passed) for point in points]) - 1


def _motion(points: Sequence[Point]) -> tuple[Array, Array, Array]:
    """Give the clamps' displacement (m) and velocity (m/s), each (n, clamps), and the time (s), (n,)."""
    displacement, velocity = (np.array([getattr(one, name) for one in points]) for name in ("displacement", "velocity"))
    return displacement, velocity, np.array([one.time for one in points])


def _received(system: SystemDescription, points: Sequence[Point]) -> Array:
    """Give what all clamps have received, J, (n,), by their own forces and the motion that they were told."""
    whole, ends = _through(points)
    displacement, velocity, time = _motion(whole)
    if system.run.scheme == "parallel":  # its master tells the clamps where they were one step before
        displacement, velocity = (np.vstack([values[:1], values[:-1]]) for values in (displacement, velocity))
    force = np.array([one.force for one in whole])
    return np.asarray(received_work(force, displacement, velocity, time).sum(axis=1)[ends])


def _delivered(system: SystemDescription, points: Sequence[Point]) -> Array:
    """Give what a pipe has given to the clamps, J, (n,), by the forces that it was told, and its motion."""
    whole, ends = _through(points)
    motion = _motion(whole)
    given = np.array([point.told for point in whole]).reshape(motion[0].shape)
    if system.run.scheme in ROLLS_BACK:
        return np.asarray(received_work(given, *motion).sum(axis=1)[ends])
    given = np.repeat(given[1:], 2, axis=0)  # held over each step
    held = [np.repeat(values, 2, axis=0)[1:-1] for values in motion]
    return np.concatenate([[0.0], received_work(given, *held).sum(axis=1)[1::2]])
