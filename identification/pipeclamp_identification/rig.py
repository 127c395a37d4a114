"""A virtual test rig: campaigns of a law whose truth is known, to ask what a test plan would see."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp import symbols
from pipeclamp.declaration import Declaration
from pipeclamp.errors import UsageError, UserError
from pipeclamp.law import Law, compose
from pipeclamp.parameter_file import LawFile, law_of
from pipeclamp.realise.arrays import Array
from pipeclamp.response import Motion, respond
from pipeclamp.symbols import CELSIUS
from pipeclamp_identification.campaign_writing import WrittenRun
from pipeclamp_identification.law_range import outside_range
from pipeclamp_identification.records import Record

SUBSTEPS = 4
"""Steps of the truth between two samples, so that states follow reversals that fall between samples."""


MOST_SAMPLES = 10_000_000
"""More at one frequency don't fit into the memory of a small machine."""


@dataclass(frozen=True)
class TestPlan:
    """What the virtual rig runs and how well it measures.

    Attributes:
        amplitudes: mm; frequencies: Hz; temperatures: degC; every combination is one run.
        cycles: cycles per record; need not be whole.
        ramp_cycles: cycles of ramp-in before them.
        rate: samples per second.
        force_noise: rms of the force sensor's noise in N.
        displacement_noise: rms of the displacement sensor's noise in mm.
        force_step, displacement_step: quantisation in N and mm; 0 for none.
        distortion: third harmonic of the drive as a share of the amplitude.
        riding: small cycles that ride on the large one, as a share of its amplitude.
        riding_order: so many of them a cycle.
        amplitude_error: rms of the amplitude's error as a share.
        temperature_error: rms of the temperature's error in K.
        seed: of the random numbers; the same seed gives the same campaign.
    """

    amplitudes: tuple[float, ...] = (0.2, 0.5, 0.8, 1.0)
    frequencies: tuple[float, ...] = (1.0, 3.0, 5.0)
    temperatures: tuple[float, ...] = (20.0, 100.0, 200.0, 300.0)
    cycles: float = 5.0
    ramp_cycles: float = 0.0
    rate: float = 1000.0
    force_noise: float = 3.0
    displacement_noise: float = 0.0002
    force_step: float = 0.1
    displacement_step: float = 0.0001
    distortion: float = 0.005
    riding: float = 0.0
    riding_order: int = 7
    amplitude_error: float = 0.005
    temperature_error: float = 1.0
    seed: int = 0

    def check(self) -> None:
        """Refuse a plan that can't be run.

        Raises:
            UsageError: a value is out of its range; the message names it.
        """
        if not (self.amplitudes and self.frequencies and self.temperatures):
            raise UsageError("test plan: got an empty list; expected at least one amplitude, frequency and temperature")
        lists = {"amplitude": self.amplitudes, "frequency": self.frequencies, "temperature": self.temperatures}
        for name, values in lists.items():
            texts = [f"{value:g}" for value in values]
            if len(set(texts)) < len(texts):
                raise UsageError(f"test plan: {name} {', '.join(texts)}; expected each value once")
        for name, values in (("amplitude", self.amplitudes), ("frequency", self.frequencies)):
            for value in values:
                if not (np.isfinite(value) and value > 0):
                    raise UsageError(f"test plan: {name} is {value:g}; expected a number above 0")
        for value in self.temperatures:
            if not (np.isfinite(value) and value > -CELSIUS):
                raise UsageError(f"test plan: temperature is {value:g} degC; expected a number above {-CELSIUS:g}")
        if not self.cycles >= 1:
            raise UsageError(f"test plan: {self.cycles:g} cycles; expected at least one whole cycle")
        samples = (self.cycles + self.ramp_cycles) * self.rate / min(self.frequencies)
        if not samples * len(self.amplitudes) * len(self.temperatures) <= MOST_SAMPLES:
            raise UsageError(
                f"test plan: {samples:.3g} samples per record at {min(self.frequencies):g} Hz; expected at most "
                f"{MOST_SAMPLES:.0e} at one frequency over all amplitudes and temperatures: fewer cycles, a lower rate"
            )
        if self.riding_order < 2:
            raise UsageError(f"test plan: riding_order is {self.riding_order}; expected a whole number above 1")
        fastest = max(self.frequencies) * (self.riding_order if self.riding > 0 else 1)
        if not self.rate >= 20 * fastest:
            raise UsageError(
                f"test plan: {self.rate:g} samples per second for {fastest:g} Hz; "
                "expected at least 20 samples per cycle"
            )
        quality = (
            "ramp_cycles", "force_noise", "displacement_noise", "force_step", "displacement_step", "distortion",
            "riding", "amplitude_error", "temperature_error",
        )  # fmt: skip
        for name in quality:
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise UsageError(f"test plan: {name} is {getattr(self, name):g}; expected a number of at least 0")


def virtual_runs(law: Law, plan: TestPlan, conditions: Mapping[str, float] | None = None) -> Iterator[WrittenRun]:
    """Run the plan on a clamp that obeys the law, rig effects included.

    Args:
        law: the truth.
        plan: what is run, and how well it is measured.
        conditions: further columns of runs.csv that the law depends on, the same in every run.

    Raises:
        UserError: the plan can't be run, or the law needs a condition that isn't given.
    """
    plan.check()
    equations = compose(law.structure)
    stated = {condition_signal(column) for column in conditions or {}}
    needed = {str(symbol) for symbol in equations.slow_signals} - {"A", "f", "T", "N"} - stated
    if needed:
        columns = sorted(_column(name) for name in needed)
        raise UserError(f"the law depends on {', '.join(columns)}; state a value for each: --set {columns[0]}=...")
    for frequency in plan.frequencies:
        yield from _runs_at(law, plan, frequency, conditions or {})


def _runs_at(law: Law, plan: TestPlan, frequency: float, conditions: Mapping[str, float]) -> Iterator[WrittenRun]:
    """Run all amplitudes and temperatures at one frequency: records of one length, marched together."""
    equations = compose(law.structure)
    pairs = list(itertools.product(plan.amplitudes, plan.temperatures))
    random = [
        np.random.default_rng([plan.seed, round(1e6 * A), round(1e6 * frequency), round(1e3 * (T + CELSIUS))])
        for A, T in pairs
    ]
    A = np.array(
        [pair[0] * (1 + plan.amplitude_error * rng.standard_normal()) for pair, rng in zip(pairs, random, strict=True)]
    )
    T = np.array(
        [pair[1] + plan.temperature_error * rng.standard_normal() for pair, rng in zip(pairs, random, strict=True)]
    )
    shift = np.array([rng.uniform(0, 2 * np.pi) for rng in random])
    fine = plan.rate * SUBSTEPS
    # One cycle that isn't recorded brings the clamp from rest into the motion, so that the drive may start anywhere.
    lead = round((1 if plan.ramp_cycles == 0 else 0) * fine / frequency)
    count = round((plan.cycles + plan.ramp_cycles) * plan.rate / frequency)
    time = (np.arange(lead + count * SUBSTEPS) - lead) / fine
    motion = _drive(plan, A, frequency, shift, time)
    slow = {
        "A": A[:, None],
        "f": np.full((len(A), 1), frequency),
        "T": T[:, None] + CELSIUS,
        "N": np.broadcast_to(np.maximum(time, 0.0) * frequency, motion[0].shape),
        **{condition_signal(column): np.full((len(A), 1), value) for column, value in conditions.items()},
    }
    truth = respond(
        equations,
        law.vector(equations),
        (law.v_r, law.y_r),
        Motion(*motion, slow, np.full((len(A), 1), 1 / fine), periodic=False),
    ).force
    if not np.all(np.isfinite(truth)):
        raise UserError(f"the law gives no finite force at {frequency:g} Hz; expected a plan near the law's range")
    kept = slice(lead, None, SUBSTEPS)
    for index, (nominal, rng) in enumerate(zip(pairs, random, strict=True)):
        name = f"A{nominal[0]:g}_f{frequency:g}_T{nominal[1]:g}".replace(".", "p").replace("-", "m")
        yield WrittenRun(
            {
                "run": name,
                "amplitude_mm": nominal[0],
                "frequency_Hz": frequency,
                "temperature_C": nominal[1],
                **conditions,
                "first_cycle": 0,
            },
            Record(
                time[kept],
                _measured(motion[0][index, kept], plan.displacement_noise, plan.displacement_step, rng),
                _measured(truth[index, kept], plan.force_noise, plan.force_step, rng),
            ),
        )


def _drive(plan: TestPlan, A: Array, frequency: float, shift: Array, time: Array) -> tuple[Array, Array, Array]:
    """Give displacement, velocity and acceleration of the drive, shape (R, n), with all tones and ramp-in."""
    omega = 2 * np.pi * frequency
    y, v, a = np.zeros((3, len(A), len(time)))
    for order, share in ((1, 1.0), (3, plan.distortion), (plan.riding_order, plan.riding)):
        phase = order * (omega * time + shift[:, None])
        y += share * A[:, None] * np.cos(phase)
        v -= share * A[:, None] * order * omega * np.sin(phase)
        a -= share * A[:, None] * (order * omega) ** 2 * np.cos(phase)
    if plan.ramp_cycles > 0:
        length = plan.ramp_cycles / frequency
        progress = np.clip(time / length, 0.0, 1.0)
        ramp = (1 - np.cos(np.pi * progress)) / 2
        rate = np.pi / (2 * length) * np.sin(np.pi * progress)
        bend = np.where(progress < 1, (np.pi / length) ** 2 / 2 * np.cos(np.pi * progress), 0.0)
        y, v, a = ramp * y, ramp * v + rate * y, ramp * a + 2 * rate * v + bend * y
    return y, v, a


def _measured(truth: Array, noise: float, step: float, rng: np.random.Generator) -> Array:
    """Give what a sensor with noise and quantisation shows."""
    shown = truth + noise * rng.standard_normal(len(truth))
    return np.round(shown / step) * step if step > 0 else shown


DENSITY = "density_g_cm3"


def condition_signal(column: str) -> str:
    """Give the name of the slow signal that a further column of runs.csv is in a law."""
    return str(symbols.rho if column == DENSITY else symbols.condition_symbol(column))


def _column(signal: str) -> str:
    """Give a column of runs.csv that is this slow signal."""
    return DENSITY if signal == str(symbols.rho) else signal.removeprefix(symbols.CONDITION)


def beyond_range(file: LawFile, plan: TestPlan) -> list[str]:
    """Say which of a plan's conditions lie beyond the data of the law that stands for the clamp."""
    planned = {
        "A": plan.amplitudes,
        "f": plan.frequencies,
        "T": tuple(value + CELSIUS for value in plan.temperatures),
    }
    words = []
    for name, values in planned.items():
        outside = outside_range(file, [f"{value:g}" for value in values], {name: np.array(values)})
        words += list(outside.values())
    return words


def truth_law(
    file: LawFile, effects: Sequence[str], values: Mapping[str, float], declared: Iterable[Declaration] = ()
) -> tuple[Law, dict[str, float]]:
    """Give the law that the virtual clamp obeys: a law file's, with further effects and other values.

    Args:
        file: the law to begin with.
        effects: names of effects to add; their parameters must be given.
        values: parameters by name; what is no parameter is a further column of runs.csv, the same in every run.
        declared: a user's own effects.

    Returns:
        the law, and the further conditions.

    Raises:
        UserError: an effect isn't known, or a parameter of an added one isn't given.
    """
    law = law_of(file)
    structure = replace(law.structure.with_declared(declared), effects=(*law.structure.effects, *effects), frozen=())
    names = compose(structure).names
    known = {**law.values, **values}
    missing = [name for name in names if name not in known]
    if missing:
        raise UserError(f"--effects {','.join(effects)}: give {', '.join(missing)} with --set name=value,...")
    conditions = {name: value for name, value in values.items() if name not in names}
    needed = {str(symbol) for symbol in compose(structure).slow_signals}
    unknown = sorted(column for column in conditions if condition_signal(column) not in needed)
    if unknown:
        further = sorted(_column(name) for name in needed - {"A", "f", "T", "N"})
        raise UserError(
            f"--set: {', '.join(unknown)} is no parameter of the law and no condition that it follows; it has "
            f"{', '.join((*names, *further))}"
        )
    return Law(structure, {name: known[name] for name in names}, law.v_r, law.y_r), conditions
