"""The virtual rig: runs of a clamp that obeys a law, as its sensors show them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_interp_spline

from pipeclamp_identification.campaign.drive import Drive, Kinematics, ramped, tones_motion
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.rig.plan import RigRun, TestPlan, plain_name
from pipeclamp_identification.campaign.rig.truth import refuse_unstated
from pipeclamp_identification.campaign.writing import WrittenRun
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.signals import signal_of
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion

SUBSTEPS = 4
"""Steps of the truth between two samples, so that states follow reversals that fall between samples."""
OF_ONE_SPECIMEN = 1_000_000
"""More repeats than any plan has."""
STIFFNESS, DAMPING = ("k10", "k30"), ("c0",)
"""Parameters of base laws by which specimens differ."""


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
    refuse_unstated(law.equations, conditions or {})
    for specimen in range(1, plan.specimens + 1) or (0,):
        own = _of_specimen(law, plan, specimen) if specimen else law
        found = [_runs_at(own, plan, frequency, conditions or {}, specimen) for frequency in plan.frequencies]
        if plan.runs:
            order = {_name(run, specimen): place for place, run in enumerate(plan.runs)}
            yield from sorted(itertools.chain(*found), key=lambda run: order[str(run.row["run"])])
        else:
            yield from itertools.chain(*found)


def _of_specimen(law: Law, plan: TestPlan, specimen: int) -> Law:
    """Give the law of one specimen: its stiffness and its damping are off by a share each."""
    if not set(STIFFNESS + DAMPING) <= set(law.values):
        raise UsageError(f"test plan: specimens differ in {', '.join(STIFFNESS + DAMPING)}, which this law hasn't got")
    shares = 1 + plan.specimen_scatter * np.random.default_rng([plan.seed, specimen]).standard_normal(2)
    values = dict(law.values)
    for names, share in ((STIFFNESS, shares[0]), (DAMPING, shares[1])):
        values |= {name: float(values[name] * share) for name in names}
    return replace(law, values=values)


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
    """Draw what chance makes of the runs at one frequency."""
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
    count = round(plan.duration_s(frequency) * plan.rate)
    time = (np.arange(lead + count * SUBSTEPS) - lead) / fine
    motion = (
        _followed(plan.drive, drawn.A / plan.amplitudes[0], time)
        if plan.drive
        else _drive(plan, drawn.A, frequency, drawn.shift, time)
    )
    motion = motion._replace(y=motion.y + (plan.about or 0.0))
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
        **{signal_of(column): value * each for column, value in conditions.items()},
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
