"""A virtual test rig: campaigns of a law whose truth is known, to ask what a test plan would see."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_interp_spline

from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.drive import Drive, Kinematics, ramped, tones_motion
from pipeclamp_identification.campaign.plausibility import fundamental_of
from pipeclamp_identification.campaign.records import Record, UnusableRecord, check_samples
from pipeclamp_identification.campaign.writing import WrittenRun
from pipeclamp_identification.signals.digits import rounded_to
from pipeclamp_models.base import signals
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UsageError, UserError, did_you_mean
from pipeclamp_models.base.signals import CONDITION
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.equations.effect import Parameter
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Equations, Law, with_effect
from pipeclamp_models.law.range import outside_range
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.realise.sizes import law_sizes, number_of

SUBSTEPS = 4
"""Steps of the truth between two samples, so that states follow reversals that fall between samples."""


MOST_SAMPLES_AT_A_FREQUENCY = 10_000_000
"""More at one frequency don't fit into the memory of a small machine."""


OF_ONE_SPECIMEN = 1_000_000
"""More repeats than any plan has."""


@dataclass(frozen=True)
class RigRun:
    """One run of a campaign that was planned: its name, mm, Hz, degC, and the load cycles before it."""

    run: str
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float
    first_cycle: float


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
        force_drift, displacement_drift: of the channels' zeros, N/s and mm/s, from each record's first sample on.
        force_gain_drift: of the force channel's gain, share per second, likewise.
        force_range, displacement_range: where the sensors end on either side, N and mm; 0 for nowhere.
        specimens: so many, each run in every combination; 0 for one without a name.
        specimen_scatter: rms share by which each specimen's stiffness, and its damping, differ from the law's.
        repeats: runs of each combination.
        seed: of the random numbers; the same seed gives the same campaign.
        drive: the displacement of every run, where it isn't made of these amplitudes, frequencies, cycles and tones.
        runs: all runs in their order, where they aren't every combination; amplitudes, frequencies and temperatures are
            theirs.
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
    force_drift: float = 0.0
    displacement_drift: float = 0.0
    force_gain_drift: float = 0.0
    force_range: float = 0.0
    displacement_range: float = 0.0
    specimens: int = 0
    specimen_scatter: float = 0.0
    repeats: int = 1
    seed: int = 0
    drive: Drive | None = None
    runs: tuple[RigRun, ...] = ()

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
                raise UsageError(f"test plan: temperature is {value:g} °C; expected a number above {-CELSIUS:g}")
        if not self.cycles >= 1:
            raise UsageError(f"test plan: {self.cycles:g} cycles; expected at least one whole cycle")
        if self.repeats < 1:
            raise UsageError(f"test plan: {self.repeats} repeats; expected at least 1")
        longest = self.drive.duration_s if self.drive else (self.cycles + self.ramp_cycles) / min(self.frequencies)
        samples = longest * self.rate
        if not samples * len(self.amplitudes) * len(self.temperatures) * self.repeats <= MOST_SAMPLES_AT_A_FREQUENCY:
            raise UsageError(
                f"test plan: {samples:.3g} samples per record at {min(self.frequencies):g} Hz; expected at most "
                f"{MOST_SAMPLES_AT_A_FREQUENCY:.0e} at one frequency over all amplitudes and temperatures: "
                "fewer cycles, a lower rate"
            )
        if self.riding_order < 2:
            raise UsageError(f"test plan: riding_order is {self.riding_order}; expected a whole number above 1")
        fastest = max(self.frequencies) * (self.riding_order if self.riding > 0 else 1)
        if self.drive:
            fastest = self.drive.highest_frequency()
        if not self.rate >= 20 * fastest:
            raise UsageError(
                f"test plan: {self.rate:g} samples per second for {fastest:g} Hz; "
                "expected at least 20 samples per cycle"
            )
        quality = (
            "ramp_cycles", "force_noise", "displacement_noise", "force_step", "displacement_step", "distortion",
            "riding", "amplitude_error", "temperature_error", "force_range", "displacement_range",
            "specimen_scatter",
        )  # fmt: skip
        for name in quality:
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise UsageError(f"test plan: {name} is {getattr(self, name):g}; expected a number of at least 0")
        for name in ("force_drift", "displacement_drift", "force_gain_drift"):
            if not np.isfinite(getattr(self, name)):
                raise UsageError(f"test plan: {name} is {getattr(self, name):g}; expected a finite number")


def driven(plan: TestPlan, drive: Drive) -> TestPlan:
    """Give a plan whose runs follow a drive signal, at the temperatures and with the sensors of another.

    Raises:
        UserError: the drive signal holds no whole cycle.
    """
    record = Record(drive.time_s, drive.displacement_mm, drive.displacement_mm)
    try:
        check_samples(record)
        cycles = find_cycles(record)
    except UnusableRecord as fault:
        raise UserError(f"drive signal: {fault}; expected whole cycles of one frequency at full amplitude") from fault
    # nominal ones: what a record shows counts
    amplitude, frequency = (
        rounded_to(value, 3) for value in (fundamental_of(record, cycles).amplitude_mm, cycles.frequency_Hz)
    )
    return replace(plan, amplitudes=(amplitude,), frequencies=(frequency,), drive=drive)


def planned(plan: TestPlan, runs: Sequence[RigRun]) -> TestPlan:
    """Give a plan of these runs, with the sensors and the cycles of another."""
    levels = (
        sorted({getattr(run, name) for run in runs}) for name in ("amplitude_mm", "frequency_Hz", "temperature_C")
    )
    amplitudes, frequencies, temperatures = map(tuple, levels)
    return replace(
        plan, amplitudes=amplitudes, frequencies=frequencies, temperatures=temperatures, repeats=1, runs=tuple(runs)
    )


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
    _refuse_unstated(law.equations, conditions or {})
    for specimen in range(1, plan.specimens + 1) or (0,):
        own = _of_specimen(law, plan, specimen) if specimen else law
        found = [_runs_at(own, plan, frequency, conditions or {}, specimen) for frequency in plan.frequencies]
        if plan.runs:
            order = {_name(run, specimen): place for place, run in enumerate(plan.runs)}
            yield from sorted(itertools.chain(*found), key=lambda run: order[str(run.row["run"])])
        else:
            yield from itertools.chain(*found)


STIFFNESS, DAMPING = ("k10", "k30"), ("c0",)
"""Parameters of base laws by which specimens differ."""


def _of_specimen(law: Law, plan: TestPlan, specimen: int) -> Law:
    """Give the law of one specimen: its stiffness and its damping are off by a share each."""
    if not set(STIFFNESS + DAMPING) <= set(law.values):
        raise UsageError(f"test plan: specimens differ in {', '.join(STIFFNESS + DAMPING)}, which this law hasn't got")
    shares = 1 + plan.specimen_scatter * np.random.default_rng([plan.seed, specimen]).standard_normal(2)
    values = dict(law.values)
    for names, share in ((STIFFNESS, shares[0]), (DAMPING, shares[1])):
        values |= {name: float(values[name] * share) for name in names}
    return replace(law, values=values)


def _refuse_unstated(equations: Equations, conditions: Mapping[str, float]) -> None:
    """Refuse a law that follows a condition which isn't stated."""
    stated = {signal_in_plan(column) for column in conditions}
    needed = equations.slow_signals - {"A", "f", "T", "N"} - stated
    if needed:
        columns = sorted(_column(name) for name in needed)
        raise UserError(f"the law depends on {', '.join(columns)}; state a value for each: --set {columns[0]}=...")


@dataclass(frozen=True)
class _Drawn:
    """The runs of a plan at one frequency (Hz) as chance has them: random numbers of each run, and amplitudes (mm),
    temperatures (degC) and phases at the beginning (rad), (R,)."""

    frequency: float
    runs: tuple[RigRun, ...]
    random: list[np.random.Generator]
    A: Array
    T: Array
    shift: Array


def _drawn_at(plan: TestPlan, frequency: float, specimen: int) -> _Drawn:
    runs, repeats = zip(*_planned_at(plan, frequency), strict=True)
    random = [
        _random(plan, run.amplitude_mm, frequency, run.temperature_C, repeat + OF_ONE_SPECIMEN * specimen)
        for run, repeat in zip(runs, repeats, strict=True)
    ]
    pairs = list(zip(runs, random, strict=True))
    A = np.array([run.amplitude_mm * (1 + plan.amplitude_error * rng.standard_normal()) for run, rng in pairs])
    T = np.array([run.temperature_C + plan.temperature_error * rng.standard_normal() for run, rng in pairs])
    return _Drawn(frequency, runs, random, A, T, np.array([rng.uniform(0, 2 * np.pi) for rng in random]))


def _runs_at(
    law: Law, plan: TestPlan, frequency: float, conditions: Mapping[str, float], specimen: int
) -> Iterator[WrittenRun]:
    """Run all amplitudes and temperatures at one frequency: records of one length, marched together."""
    drawn = _drawn_at(plan, frequency, specimen)
    fine = plan.rate * SUBSTEPS
    # One cycle that isn't recorded brings the clamp from rest into the motion, so that the drive may start anywhere.
    lead = 0 if plan.drive or plan.ramp_cycles > 0 else round(fine / frequency)
    longest = plan.drive.duration_s if plan.drive else (plan.cycles + plan.ramp_cycles) / frequency
    count = round(longest * plan.rate)
    time = (np.arange(lead + count * SUBSTEPS) - lead) / fine
    motion = (
        _followed(plan.drive, drawn.A / plan.amplitudes[0], time)
        if plan.drive
        else _drive(plan, drawn.A, frequency, drawn.shift, time)
    )
    truth = _true_force(law, drawn, conditions, motion, time, fine)
    kept = slice(lead, None, SUBSTEPS)
    for index, (run, rng) in enumerate(zip(drawn.runs, drawn.random, strict=True)):
        yield WrittenRun(
            {
                "run": _name(run, specimen),
                "amplitude_mm": run.amplitude_mm,
                "frequency_Hz": frequency,
                "temperature_C": run.temperature_C,
                **conditions,
                **({"specimen": f"S{specimen}"} if specimen else {}),
                "first_cycle": run.first_cycle,
            },
            _recorded(plan, time[kept], motion.y[index, kept], truth[index, kept], rng),
        )


def _true_force(
    law: Law, drawn: _Drawn, conditions: Mapping[str, float], motion: Kinematics, time: Array, rate: float
) -> Array:
    """Give a law's force in runs of so many steps a second, N, shape (R, n)."""
    each = np.ones((len(drawn.runs), 1))
    slow = {
        "A": drawn.A[:, None],
        "f": drawn.frequency * each,
        "T": drawn.T[:, None] + CELSIUS,
        "N": np.array([run.first_cycle for run in drawn.runs])[:, None] + np.maximum(time, 0.0) * drawn.frequency,
        **{signal_in_plan(column): value * each for column, value in conditions.items()},
    }
    equations, given = law.equations, Motion(*motion, slow, each / rate, periodic=False)
    force = force_of_equations(equations, law.vector(equations), (law.v_r, law.y_r), given).force
    if not np.all(np.isfinite(force)):
        raise UserError(
            f"the law gives no finite force at {drawn.frequency:g} Hz; expected a plan near the law's range"
        )
    return force


def _recorded(plan: TestPlan, time: Array, displacement: Array, force: Array, rng: np.random.Generator) -> Record:
    """Give what a rig's sensors, which drift, show of a run."""
    shown = displacement + plan.displacement_drift * time
    pushed = force * (1 + plan.force_gain_drift * time) + plan.force_drift * time
    return Record(
        time,
        _measured(shown, plan.displacement_noise, plan.displacement_step, plan.displacement_range, rng),
        _measured(pushed, plan.force_noise, plan.force_step, plan.force_range, rng),
    )


def _planned_at(plan: TestPlan, frequency: float) -> list[tuple[RigRun, int]]:
    """Give the runs of a plan at a frequency, and which of the random numbers of its condition each has."""
    if plan.runs:
        return [(run, place) for place, run in enumerate(plan.runs, 1) if run.frequency_Hz == frequency]
    found = []
    for A, T, repeat in itertools.product(plan.amplitudes, plan.temperatures, range(plan.repeats)):
        name = plain_name(f"A{A:g}_f{frequency:g}_T{T:g}")
        name += f"_{repeat + 1}" if plan.repeats > 1 else ""
        found.append((RigRun(name, A, frequency, T, 0), repeat))
    return found


def plain_name(text: str) -> str:
    """Give a name of a run or a file that says numbers without points and signs: A0p5 for A0.5."""
    return text.replace(".", "p").replace("-", "m")


def _name(run: RigRun, specimen: int) -> str:
    return f"{run.run}_S{specimen}" if specimen else run.run


def _random(plan: TestPlan, A: float, frequency: float, T: float, repeat: int) -> np.random.Generator:
    """Give a run's own random numbers; those of first runs are the same, whether there are repeats or not."""
    key = [plan.seed, round(1e6 * A), round(1e6 * frequency), round(1e3 * (T + CELSIUS))]
    return np.random.default_rng([*key, repeat] if repeat else key)


def _drive(plan: TestPlan, A: Array, frequency: float, shift: Array, time: Array) -> Kinematics:
    """Give displacement, velocity and acceleration of the drive, shape (R, n), with all tones and ramp-in."""
    tones = ((1, 1.0), (3, plan.distortion), (plan.riding_order, plan.riding))
    motion = tones_motion(tones, A[:, None], frequency, 2 * np.pi * frequency * time + shift[:, None])
    if plan.ramp_cycles > 0:
        speed = frequency / plan.ramp_cycles
        motion = ramped(motion, np.clip(time * speed, 0.0, 1.0), speed)
    return motion


def _followed(drive: Drive, share: Array, time: Array) -> Kinematics:
    """Give the motion of runs that follow a drive signal, each at its share of it, shape (R, n)."""
    spline = make_interp_spline(drive.time_s, drive.displacement_mm, k=5)
    within = np.minimum(time, drive.time_s[-1])
    return Kinematics(*(share[:, None] * spline(within, derivative) for derivative in range(3)))


def _measured(truth: Array, noise: float, step: float, end: float, rng: np.random.Generator) -> Array:
    """Give what a sensor with noise, quantisation and an end of its range shows."""
    shown = truth + noise * rng.standard_normal(len(truth))
    shown = np.clip(shown, -end, end) if end > 0 else shown
    return np.round(shown / step) * step if step > 0 else shown


DENSITY = "density_g_cm3"


def signal_in_plan(column: str) -> str:
    """Give the name of the slow signal that a further column of runs.csv is in a law."""
    return "rho" if column == DENSITY else signals.condition_signal(column)


def _column(signal: str) -> str:
    """Give a column of runs.csv that is this slow signal."""
    return DENSITY if signal == "rho" else signal.removeprefix(CONDITION)


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


@dataclass(frozen=True)
class Truth:
    """What the virtual clamp obeys.

    Attributes:
        law: the law.
        conditions: further columns of runs.csv, the same in every run.
        whence: where each parameter's value is from that the law's file doesn't state: SET or TYPICAL, by name.
    """

    law: Law
    conditions: Mapping[str, float]
    whence: Mapping[str, str]


SET = "--set"
TYPICAL = "typical size"


def truth_of(
    file: LawFile,
    effects: Sequence[str],
    values: Mapping[str, float],
    plan: TestPlan,
    declared: Iterable[Declaration] = (),
) -> Truth:
    """Give what the virtual clamp obeys: a law file's law, with further effects and other values.

    Args:
        file: the law to begin with.
        effects: names of effects to add.
        values: parameters by name, each in its unit; what is no parameter is a further column of runs.csv, the same in
            every run. A parameter of an added effect that isn't named gets a typical size, for the loops of the law
            under the plan.
        plan: what is run.
        declared: a user's own effects.

    Raises:
        UserError: an effect isn't known or is there already, a value is neither a parameter's
            nor a condition's, or it is out of bounds.
    """
    law = law_of(file)
    structure = replace(law.structure.with_declared(declared), frozen=())
    for effect in effects:
        structure = with_effect(structure, effect)
    equations = structure.equations
    followed = equations.slow_signals
    conditions = {name: value for name, value in values.items() if name not in equations.names}
    unknown = sorted(column for column in conditions if signal_in_plan(column) not in followed)
    if unknown:
        columns = sorted(_column(name) for name in followed - {"A", "f", "T", "N"})
        known = [*equations.names, *columns]
        units = ", ".join([*(f"{one.name} ({one.unit})" for one in equations.parameters), *columns])
        raise UserError(
            f"--set: {', '.join(unknown)} is no parameter of the law and no condition that it follows; "
            f"{did_you_mean(unknown[0], known)}it has {units}"
        )
    parameters = equations.composed.parameters
    for parameter in parameters:
        _refuse_beyond(parameter, values.get(parameter.name))
    given = {**law.values, **values}
    lacking = [parameter for parameter in parameters if parameter.name not in given]
    typical: dict[str, float] = {}
    if lacking:
        _refuse_unstated(equations, conditions)
        plan.check()
        further = {signal_in_plan(column): value for column, value in conditions.items()}
        temperatures = [T + CELSIUS for T in plan.temperatures]
        slow = {"N": plan.cycles, **further}
        sizes = law_sizes(law, plan.amplitudes, plan.frequencies, temperatures, slow)
        typical = {parameter.name: number_of(parameter.size, sizes) for parameter in lacking}
    whence = {name: SET for name in values if name in equations.names} | dict.fromkeys(typical, TYPICAL)
    known_values = {**given, **typical}
    return Truth(
        Law(structure, {name: known_values[name] for name in equations.names}, law.v_r, law.y_r), conditions, whence
    )


def _refuse_beyond(parameter: Parameter, value: float | None) -> None:
    """Refuse a value beyond bounds that are numbers, which physics sets; others hang on the data's sizes."""
    lower, upper = (
        bound if isinstance(bound, int | float) else otherwise
        for bound, otherwise in ((parameter.lower, -np.inf), (parameter.upper, np.inf))
    )
    if value is not None and not lower <= value <= upper:
        expected = f"at least {lower:g}" if upper == np.inf else f"{lower:g} to {upper:g}"
        raise UserError(
            f"--set: {parameter.name} = {value:g} {parameter.unit} ({parameter.meaning}); expected {expected}"
        )
