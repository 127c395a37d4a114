"""The result of a co-simulation: its columns, its energy balance, and what a person should know of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl
from numpy.typing import NDArray

from pipeclamp.files import write_whole
from pipeclamp_identification.coupling import Scheme
from pipeclamp_identification.energy import EnergyBalance
from pipeclamp_identification.system import LawMode

Array = NDArray[np.float64]

MISMATCH = 0.2
"""Share by which the amplitude of the motion may differ from the one that the law is taken for, before it is said."""


@dataclass(frozen=True, eq=False)
class CosimResult:
    """What a co-simulation gave.

    Attributes:
        name: of the system.
        scheme: how it was coupled.
        step: macro step, s.
        excitation_kind: "base" or "force".
        clamp_names: the clamps that have a law, in the system's order.
        probe_names: the pipe's probes.
        columns: values by variable name, each (n,); SI units.
        units: unit of each column.
        energy: the balance, each (n,).
        out_of_range: clamps whose law was used beyond its data.
        warnings: what the FMUs warned of.
        modes: where each clamp's A and f come from.
        runs: how many it took to solve A and f.
        trusted_share: of the energy, that the coupling may make, and of a clamp's motion, that may be hidden.
        hidden_share: of a clamp's motion, that passes between the communication points.
        unsolved: by which share they still changed in the last run, where they were not solved.
    """

    name: str
    scheme: Scheme
    step: float
    excitation_kind: str
    clamp_names: tuple[str, ...]
    probe_names: tuple[str, ...]
    columns: Mapping[str, Array]
    units: Mapping[str, str]
    energy: EnergyBalance
    out_of_range: tuple[str, ...]
    warnings: tuple[str, ...]
    modes: tuple[LawMode, ...]
    trusted_share: float
    hidden_share: float
    runs: int = 1
    unsolved: float = 0.0

    @property
    def time(self) -> Array:
        """Communication points, s, (n,)."""
        return self.columns["time"]

    @property
    def coupling_share(self) -> float:
        """Energy that the coupling made or destroyed at most, as a share of all that was moved."""
        return self.energy.coupling_share

    @property
    def trusted(self) -> bool:
        """Whether the coupling made no more of the energy, and hid no more of the motion, than the stated share."""
        return max(self.coupling_share, self.hidden_share) <= self.trusted_share

    def doubts(self) -> list[tuple[str, str]]:
        """Say why it isn't to be trusted: what is wrong, and what helps."""
        energy = f"the coupling itself made {self.coupling_share:.1%} of the energy"
        motion = f"{self.hidden_share:.1%} of a clamp's motion passes between the steps"
        found = []
        if self.coupling_share > self.trusted_share:
            found.append((energy, "use a smaller step_s, energy_tolerance, or scheme = 'implicit'"))
        if self.hidden_share > self.trusted_share:
            found.append((motion, "use another, smaller step_s: a mode of the pipe may ring at a multiple of 1/step_s"))
        return found

    def amplitude(self, column: str, share: float = 0.2) -> float:
        """Give half the peak-to-peak value of a column over the last share of the run."""
        first = min(int(np.searchsorted(self.time, (1 - share) * self.time[-1])), self.time.size - 2)
        values = self.columns[column][first:]
        return float(values.max() - values.min()) / 2

    def summary(self) -> str:
        """Give amplitudes and the energy balance, for a person to read."""
        trials = self.columns["trials"][1:]
        lines = [
            f"system {self.name!r}: {self.time.size - 1} {self.scheme} steps of {self._step_text()}, "
            f"{trials.mean():.1f} trials a step (at most {trials.max():.0f})"
        ]
        lines += [
            f"{name}: amplitude {1e3 * self.amplitude(f'{name}.s'):.4g} mm, "
            f"force {self.amplitude(f'{name}.f'):.4g} N over the last fifth"
            for name in self.clamp_names
        ]
        lines += [
            f"{name}: amplitude {1e3 * self.amplitude(f'{name}.s'):.4g} mm over the last fifth"
            for name in self.probe_names
        ]
        lines += [
            f"NOT TO BE TRUSTED: {what}, expected at most {self.trusted_share:.1%}; {remedy}"
            for what, remedy in self.doubts()
        ]
        lines.append("energy, J: " + ", ".join(f"{name} {value:.4g}" for name, value in self.energy.final().items()))
        lines += [
            f"{name}: its law is taken for an amplitude of {1e3 * assumed:.4g} mm, and it moves with {1e3 * found:.4g} "
            "mm: set amplitude_mm to that, or solve = true, or track = true"
            for name in self.clamp_names
            if abs((found := self.amplitude(f"{name}.s")) - (assumed := self.columns[f"{name}.A_used"][-1]))
            > MISMATCH * assumed
        ]
        lines += [self._about_conditions(name, mode) for name, mode in zip(self.clamp_names, self.modes, strict=True)]
        lines += [f"{name}: its law was used beyond the range of its data" for name in self.out_of_range]
        lines += [f"warning: {warning}" for warning in self.warnings]
        return "\n".join(lines)

    def _step_text(self) -> str:
        """Give the macro steps' lengths."""
        steps = np.diff(self.time)
        if np.ptp(steps) < 1e-6 * steps.max():
            return f"{self.step:g} s"
        return f"{steps.min():.3g} to {steps.max():.3g} s"

    def _about_conditions(self, name: str, mode: LawMode) -> str:
        """Say where a law's A and f come from."""
        amplitude, frequency = 1e3 * self.columns[f"{name}.A_used"][-1], self.columns[f"{name}.f_used"][-1]
        if amplitude != amplitude:
            return f"{name}: not one of our FMUs; it doesn't say what A and f its law was taken for"
        used = f"A = {amplitude:.4g} mm, f = {frequency:.4g} Hz"
        if mode == "solved" and self.unsolved:
            return f"{name}: A and f NOT solved in {self.runs} runs, they still change by {self.unsolved:.1%}: {used}"
        how = {"given": "as given", "solved": f"solved in {self.runs} runs", "tracked": "tracked, at the end"}[mode]
        return f"{name}: its law is taken for {used} ({how})"


def write_result(result: CosimResult, path: Path) -> None:
    """Write a result as CSV, whole or not at all: one row per communication point, "name [unit]" as header.

    Raises:
        UserError: the folder can't be written.
    """
    frame = pl.DataFrame({f"{name} [{result.units[name]}]": values for name, values in result.columns.items()})
    trusted = pl.lit(float(result.trusted)).alias("trusted [1 yes, 0 no]")
    write_whole(path, frame.with_columns(trusted).write_csv())
