"""The result of a co-simulation: its columns, its energy balance, and whether it is to be trusted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np

from pipeclamp_fmu.slaves.own_motion import LIMIT
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.base.tables import pl
from pipeclamp_system.cosim.beating import Beats, Swing, swing_of
from pipeclamp_system.cosim.energy import EnergyBalance
from pipeclamp_system.cosim.repetition import LAST_SHARE, REPEATING_SHARE, off_a_cycle_before
from pipeclamp_system.description.scheme import ORDER, ROLLS_BACK, Scheme
from pipeclamp_system.description.system import SystemDescription
from pipeclamp_system.description.trust_mark import doubt

FEWEST_STEPS_PER_PERIOD = 10
"""Of a period of the excitation: what is sampled more coarsely than that is no longer the same motion."""

SETTLED_SHARE = 0.01
"""Share by which the amplitude may change from the last fifth but one of a run to the last, before it is said."""

UNEVEN_SHARE = 1e-6
"""Share by which steps of one length may differ by rounding."""

STEP_MARGIN = 0.95
"""Of a step that is proposed: it is said in two digits."""


@dataclass(frozen=True, eq=False)
class CosimResult:
    """What a co-simulation gave.

    Attributes:
        system: as it was run: by which scheme, in which steps, with which A and f; its FMUs are gone.
        probe_names: the pipe's probes.
        columns: values by variable name, each (n,); SI units.
        units: unit of each column.
        energy: the balance, each (n,).
        out_of_range: clamps whose law was used beyond its data.
        warnings: what the FMUs warned of.
        hidden_share: of a clamp's motion, that passes between the communication points.
        runs: how many it took to solve A and f.
        unsolved: by which share they still changed in the last run, where they were not solved.
        step_error: of the displacement, owed to the macro step, as a share of it; infinite where no other step could
            tell, None where none was asked.
        order: power of the step with which that falls, as the other run tells; None where none was asked.
        means_told: whether the pipe was told each step's mean force, not one that is linear over it.
        beats: a swing of the amplitude of a clamp whose law is tracked; None where there is none.
        leaves_rest: whether clamps push the pipe out of its rest, to places of rest on either side of it if to any.
    """

    system: SystemDescription
    probe_names: tuple[str, ...]
    columns: Mapping[str, Array]
    units: Mapping[str, str]
    energy: EnergyBalance
    out_of_range: tuple[str, ...]
    warnings: tuple[str, ...]
    hidden_share: float
    runs: int = 1
    unsolved: float = 0.0
    step_error: float | None = None
    order: int | None = None
    means_told: bool = False
    beats: Beats | None = None
    leaves_rest: bool = False

    @property
    def name(self) -> str:
        """Of the system."""
        return self.system.name

    @property
    def scheme(self) -> Scheme:
        """How it was coupled."""
        return self.system.run.scheme

    @property
    def step(self) -> float:
        """Macro step, s; the longest where it follows the energy."""
        return self.system.run.even_step_s

    @property
    def trusted_share(self) -> float:
        """Share of the energy that the coupling may make, of the displacement that it may err by, and so on."""
        return self.system.run.trusted_share

    @property
    def clamp_names(self) -> tuple[str, ...]:
        """The clamps that have a law, in the system's order."""
        return tuple(clamp.at for clamp in self.system.clamps)

    @property
    def time(self) -> Array:
        """Communication points, s, (n,)."""
        return self.columns["time"]

    @property
    def coupling_share(self) -> float:
        """Energy that the coupling made or destroyed at most, as a share of what the excitation gave."""
        return self.energy.coupling_share

    @property
    def steps_a_period(self) -> float:
        """Macro steps in a period of the excitation, at its highest frequency and the longest step."""
        frequency = self.system.excitation.highest_frequency
        return float("inf") if frequency is None else 1 / (frequency * float(np.diff(self.time).max()))

    @property
    def trusted(self) -> bool:
        """Whether steps are short, and neither energy made, nor error, nor hidden motion is beyond the stated share."""
        return not self.doubts()

    @property
    def settles(self) -> bool:
        """Whether the excitation is one sine, so that the motion settles."""
        return self.system.excitation.kind == "sine"

    def swing(self, clamp: str) -> Swing | None:
        """Give how the amplitude of a clamp goes to and fro at the end of a run under a sine; None where it doesn't."""
        frequency = self.system.excitation.frequency_Hz
        if not self.settles or frequency is None:
            return None
        return swing_of(self.time, self.columns[f"{clamp}.s"], frequency)

    @property
    def unsettled(self) -> dict[str, float]:
        """By which share the amplitude of each point still changes over the last two fifths, where it is too much."""
        if not self.settles:
            return {}
        changes = {}
        for name in (*self.clamp_names, *self.probe_names):
            last, before = self.amplitude(f"{name}.s"), self.amplitude(f"{name}.s", 0.4, 0.2)
            change = abs(last / before - 1) if before > 0 else 0.0
            if change > SETTLED_SHARE:
                changes[name] = change
        return changes

    @property
    def unrepeated(self) -> dict[str, float]:
        """By which share of its motion each point differs from a cycle of the sine before, where it is too much."""
        frequency = self.system.excitation.frequency_Hz
        if not self.settles or frequency is None:
            return {}
        points = (*self.clamp_names, *self.probe_names)
        off = {name: off_a_cycle_before(self.time, self.columns[f"{name}.s"], frequency) for name in points}
        return {name: share for name, share in off.items() if share > REPEATING_SHARE}

    def doubts(self) -> list[tuple[str, str]]:
        """Say why it isn't to be trusted: what is wrong, what was expected, and what helps."""
        energy = f"the coupling itself made {self.coupling_share:.2%} of the energy"
        heat = f"the clamps gave out {self.energy.clamps_share:.2%} of the energy, more than they ever took in"
        motion = f"{self.hidden_share:.2%} of a clamp's motion passes between the steps"
        most = f"expected at most {self.trusted_share:.2%}"
        found = []
        if self.steps_a_period < FEWEST_STEPS_PER_PERIOD:
            few = f"there are {self.steps_a_period:.2g} steps in a period of the excitation"
            found.append((few, f"expected at least {FEWEST_STEPS_PER_PERIOD}; use a smaller step_s"))
        if self.coupling_share > self.trusted_share:
            other = "" if self.scheme in ROLLS_BACK else ", or scheme = 'implicit'"
            found.append((energy, f"{most}; use a smaller step_s or energy_tolerance{other}"))
        if self.energy.clamps_share > self.trusted_share:
            found.append((heat, f"{most}; use a smaller step_s"))
        if self.step_error is not None and self.step_error > self.trusted_share:
            told = f"{most} in amplitude and phase; {self._shorter_step(self.step_error)}"
            found.append((self._about_step(self.step_error), told))
        if self.hidden_share > self.trusted_share:
            remedy = "use another, smaller step_s: a mode of the pipe may ring at a multiple of 1/step_s"
            found.append((motion, f"{most}; {remedy}"))
        if self.beats is not None:
            found.append(_about_beats(self.beats))
        return found

    def remedy(self) -> str:
        """Say in few words what helps where it isn't to be trusted."""
        if self.beats is not None:
            settles = self.beats.settles_at is not None
            return "with solve = true in place of track = true" if settles else "with a larger stop_s"
        if self.leaves_rest:
            return "with clamps between which the pipe stays at rest"
        error = self.step_error or 0.0
        right = self._right_step(error) if error > self.trusted_share else None
        return "with a smaller step_s" if right is None else f"with step_s = {right:.2g} or less"

    @property
    def mistaken(self) -> tuple[str, ...]:
        """The clamps whose law is given an A and f that the motion doesn't have, so that its force is off."""
        return tuple(
            clamp.at
            for clamp in self.system.clamps
            if clamp.mode == "given" and self.columns[f"{clamp.at}.forceDeviation"][-1] > LIMIT
        )

    def marks(self) -> list[str]:
        """Give the lines that say so wherever the result is shown; none where it is to be trusted."""
        return [doubt(f"{what}, {rest}") for what, rest in self.doubts()]

    def _about_step(self, error: float) -> str:
        """Say by how much the motion is off."""
        if error == inf:
            return "the displacement's error isn't known, as no run in other steps tells it"
        return f"the displacement errs by {error:.2%} for its steps"

    def _shorter_step(self, error: float) -> str:
        """Say what would make the motion's error the expected one."""
        if self.leaves_rest:
            return (
                "the pipe leaves its rest, see the warning: where it swings from side to side irregularly, runs in two "
                "steps part, however short these are"
            )
        better = "" if self.scheme in ROLLS_BACK else ", or scheme = 'implicit'"
        right = self._right_step(error)
        if right is None:
            return f"use a smaller step_s or energy_tolerance{better}"
        return f"use step_s = {right:.2g} or less{better}"

    def _right_step(self, error: float) -> float | None:
        """Give a step that makes the motion's error the expected one; None where none can be foretold."""
        if error == inf or np.ptp(np.diff(self.time)) > UNEVEN_SHARE * self.step:
            return None
        power = 1 / (self.order or ORDER[self.scheme])
        return STEP_MARGIN * self.step * float((self.trusted_share / error) ** power)

    def amplitude(self, column: str, share: float = LAST_SHARE, but: float = 0.0) -> float:
        """Give half the peak-to-peak value of a column over the last share of the run, but for the very last one."""
        last = int(np.searchsorted(self.time, (1 - but) * self.time[-1], side="right"))
        first = min(int(np.searchsorted(self.time, (1 - share) * self.time[-1])), last - 2)
        values = self.columns[column][max(first, 0) : last]
        return float(values.max() - values.min()) / 2


def _about_beats(beats: Beats) -> tuple[str, str]:
    """Say that an amplitude swings, whether for its tracker alone, and what the clamp does."""
    swing = beats.swing
    period = "" if swing.period is None else f", once in {swing.period:.3g} s"
    what = f"the amplitude at {beats.name} swings between {1e3 * swing.low:.4g} and {1e3 * swing.high:.4g} mm{period}"
    held = f"with the law held at A = {1e3 * beats.held_at:.4g} mm"
    if beats.failed is not None:
        return what, f"and whether for its tracker alone isn't known: {held} the run fails ({beats.failed})"
    if beats.settles_at is None:
        remedy = "a larger stop_s tells whether it dies down; a law with memory needs no A"
        return what, f"and not for its tracker alone: {held} an amplitude swings too; {remedy}"
    comes = f"{held}, solved, it comes to" if beats.solved else f"{held} (not solved) it comes to"
    return (
        f"{what}, for its law follows it with a delay",
        f"while {comes} {1e3 * beats.settles_at:.4g} mm; use solve = true in place of track = true, or a law with "
        "memory, whose stiffness doesn't hang on A",
    )


def write_result(result: CosimResult, path: Path) -> None:
    """Write a result as CSV, whole or not at all: one row per communication point, "name [unit]" as header.

    Raises:
        UserError: the folder can't be written.
    """
    frame = pl.DataFrame({f"{name} [{result.units[name]}]": values for name, values in result.columns.items()})
    trusted = pl.lit(float(result.trusted)).alias("trusted [1 yes, 0 no]")
    settled = pl.lit(float(not result.unsettled and result.beats is None) if result.settles else None, pl.Float64)
    known = settled.alias("settled [1 yes, 0 no, empty where nothing settles]")
    error = pl.lit(None if result.step_error in (None, inf) else result.step_error, pl.Float64)
    told = error.alias("step_error [share of the displacement, empty where not known]")
    write_whole(path, frame.with_columns(trusted, known, told).write_csv())
