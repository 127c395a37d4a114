"""Co-simulations on a frequency response, each in steps that make it right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, inf, log
from pathlib import Path

from pipeclamp_models.base.errors import UserError
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.run import run_described
from pipeclamp_system.description.system import SystemDescription

TRANSIENT_LEFT = 1e-3
"""A co-simulation runs until its transient has fallen to this share."""

FEWEST_CYCLES_RUN, MOST_CYCLES_RUN, LAST_CYCLES = 15, 600, 4
"""Of a co-simulation; its amplitude is that of the last ones, which come after the others."""

FEWEST_STEPS_PER_CYCLE = 16
"""Of a cycle."""

CLOSE_SHARE = 0.01
"""Share of the energy that the coupling may make, of a clamp's motion that may pass between the steps, and of the
amplitude by which a dot may be off the curve before a finer run must confirm it."""

MOST_HALVINGS = 4
"""Of the step; a dot that still isn't right then is drawn as not to be trusted."""


@dataclass(frozen=True)
class Rest:
    """A stable state, to which a co-simulation may come.

    Attributes:
        amplitudes: half the peak-to-peak displacement of each clamp and probe, mm.
        decay: with which what is off it dies out, 1/s.
        truncated: share of its motion that lies in harmonics which are left out.
    """

    amplitudes: tuple[float, ...]
    decay: float
    truncated: float


@dataclass(frozen=True)
class Dot:
    """A co-simulation.

    Attributes:
        temperature, level: as of its curve.
        frequency: Hz.
        amplitudes: half the peak-to-peak displacement of each clamp and probe, mm.
        expected: the same of the stable state of the curve that is nearest to it; its own where there is none.
        truncated: share of that state's motion which lies in harmonics that are left out; None where there is none.
        settled: whether it ran until its transient was gone.
        step: macro step, s: the system's, halved until the dot could be trusted.
        trusted: whether it can be at that step.
        repeats: whether its motion is the same in each cycle; curves hold no other.
    """

    temperature: float | None
    level: float
    frequency: float
    amplitudes: tuple[float, ...]
    expected: tuple[float, ...]
    truncated: float | None
    settled: bool
    step: float
    trusted: bool
    repeats: bool = True

    @property
    def has_branch(self) -> bool:
        """Whether the curve has a stable state at its frequency."""
        return self.truncated is not None

    @property
    def difference(self) -> float:
        """Largest difference between co-simulation and harmonic balance, as a share of the latter."""
        return largest_difference(self.amplitudes, self.expected)


def largest_difference(found: Sequence[float], wanted: Sequence[float]) -> float:
    """Give the largest difference of amplitudes, as a share of the wanted ones."""
    pairs = zip(found, wanted, strict=True)
    return max((abs(ours / theirs - 1) for ours, theirs in pairs if theirs > 0), default=0.0)


def co_simulated(
    system: SystemDescription, temperature: float | None, level: float, frequency: float,
    stable: Sequence[Rest], path: Path,
) -> Dot:  # fmt: skip
    """Co-simulate a system at one frequency until its transient is gone.

    The run is as long as the slowest stable state asks for, and longer where it still moves. The step is halved until
    the coupling neither makes nor hides more than `CLOSE_SHARE`, and until the dot lies on the curve or stands still
    where it is. Both are needed: two steps that meet the same mode of the pipe agree with each other.

    Args:
        system: its FMUs finished.
        temperature: of all clamps, degC; None for their own.
        level: factor on the excitation's amplitude.
        frequency: Hz.
        stable: the curve's stable states there.
        path: SYSTEM.toml; paths in it are relative to its folder.

    Raises:
        UserError: the finest run fails.
    """
    shaken = _shaken(system, temperature, level, frequency)
    longest = 1 / (frequency * _steps_a_cycle(system))
    cycles = max((_cycles_to(rest, frequency) for rest in stable), default=MOST_CYCLES_RUN)
    cycles = min(max(cycles, FEWEST_CYCLES_RUN), MOST_CYCLES_RUN)
    halvings, before = 0, None
    while True:
        step = longest / 2**halvings
        run = system.run.model_copy(update={"stop_s": (cycles + LAST_CYCLES) / frequency, "step_s": step})
        try:
            finer = shaken.model_copy(update={"run": run})
            result = run_described(finer, path.parent, str(path), checked=False)
        except UserError:  # too long a step can diverge, or find no forces
            if halvings == MOST_HALVINGS:
                raise
            halvings += 1
            continue
        if result.unsettled and cycles < MOST_CYCLES_RUN:  # beside a fold it lingers where there is no state any more
            cycles = min(2 * cycles, MOST_CYCLES_RUN)
            continue
        names = (*result.clamp_names, *result.probe_names)
        found = tuple(1e3 * result.amplitude(f"{name}.s", LAST_CYCLES / (cycles + LAST_CYCLES)) for name in names)
        near = min(stable, key=lambda rest: abs(rest.amplitudes[-1] - found[-1]), default=None)
        expected = near.amplitudes if near else found
        moved = inf if before is None else largest_difference(found, before)
        trusted = _well_coupled(result) and min(largest_difference(found, expected), moved) <= CLOSE_SHARE
        if trusted or halvings == MOST_HALVINGS:
            settled = not result.unsettled and (near is None or _cycles_to(near, frequency) <= cycles)
            truncated = near.truncated if near else None
            repeats = not result.unrepeated
            return Dot(temperature, level, frequency, found, expected, truncated, settled, step, trusted, repeats)
        halvings, before = halvings + 1, found


def _cycles_to(rest: Rest, frequency: float) -> int:
    """Give in how many cycles of a frequency (Hz) a transient to a state has fallen to `TRANSIENT_LEFT`."""
    return ceil(frequency * log(1 / TRANSIENT_LEFT) / rest.decay)


def _well_coupled(result: CosimResult) -> bool:
    return max(result.coupling_share, result.hidden_share) <= CLOSE_SHARE and not result.unsolved


def _shaken(system: SystemDescription, temperature: float | None, level: float, frequency: float) -> SystemDescription:
    """Give the system shaken by a sine."""
    excitation = system.excitation
    amplitudes = {
        name: level * value
        for name in ("acceleration_m_s2", "displacement_mm", "force_N")
        if (value := getattr(excitation, name)) is not None
    }
    sine = {"kind": "sine", "frequency_Hz": frequency, "from_Hz": None, "to_Hz": None, **amplitudes}
    clamps = system.clamps
    if temperature is not None:
        clamps = tuple(clamp.model_copy(update={"temperature_C": temperature}) for clamp in clamps)
    return system.model_copy(update={"excitation": excitation.model_copy(update=sine), "clamps": clamps})


def _steps_a_cycle(system: SystemDescription) -> int:
    """Give how many macro steps the system asks for in a cycle of its own excitation."""
    excitation = system.excitation
    middle = excitation.frequency_Hz or ((excitation.from_Hz or 0.0) + (excitation.to_Hz or 0.0)) / 2
    return max(FEWEST_STEPS_PER_CYCLE, round(1 / (middle * system.run.step_s)))
