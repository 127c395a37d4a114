"""The coupled model through a record: what its probes should have shown, for many neighbouring models at once."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.on_pipe.model import CoupledModel
from pipeclamp_identification.on_pipe.record_files import MotionRecord
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.pipe.modes import ReducedPipe
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.transient.march import HeldLaw, MarchedModels, Variant, march

AmplitudesAndFrequencies = tuple[tuple[float, float], ...]

PASSES, SAME = 4, 0.02
"""Runs in which a law's A and f are brought to those of the motion, until they change by less than this share."""
TIME_ERROR = 1e-3
"""Share of the rms by which the time step may change what probes show: well below what sensors err by."""
MOST_SUBSTEPS = 32
"""Steps between two samples at most."""
MODELS_AT_ONCE = 60
"""Models that are marched together; more of them leave the processor's cache."""


@dataclass(frozen=True, eq=False)
class RecordPrediction:
    """What a model says of a record.

    Attributes:
        computed: SI, (n, probes).
        conditions: A (mm) and f (Hz) that each clamp's law was taken for.
    """

    computed: Array
    conditions: AmplitudesAndFrequencies


def predict_record(
    models: Sequence[CoupledModel], record: MotionRecord, every: int, near: Sequence[AmplitudesAndFrequencies | None]
) -> list[RecordPrediction | None]:
    """Give what models say of a record; None for a pipe that can't be reduced.

    Args:
        models: pipe and clamps, alike but for values.
        record: the record.
        every: steps between two samples.
        near: A and f of the laws to begin with, of each model; None: the law's own.
    """
    pipes: dict[int, ReducedPipe] = {}
    for index, model in enumerate(models):
        with suppress(UserError, np.linalg.LinAlgError):
            pipes[index] = _pipe(model, record)
    predicted = _predicted([(pipe, models[index], near[index]) for index, pipe in pipes.items()], record, every)
    by_index = dict(zip(pipes, predicted, strict=True))
    return [by_index.get(index) for index in range(len(models))]


def _predicted(
    coupled: Sequence[tuple[ReducedPipe, CoupledModel, AmplitudesAndFrequencies | None]],
    record: MotionRecord,
    every: int,
) -> list[RecordPrediction]:
    """Give what models, by their pipes and where their laws' A and f begin, say of a record."""
    laws = [[clamp for _, clamp in model.clamps[record.temperature]] for _, model, _ in coupled]
    taken = [near or tuple(map(_begun, own)) for (_, _, near), own in zip(coupled, laws, strict=True)]
    found: dict[int, RecordPrediction] = {}
    waiting = list(range(len(coupled)))
    drive = record.finer_drive(every)
    orders = [probe.order for probe in record.probes]
    names = [probe.name for probe in record.probes]
    for _ in range(PASSES):
        for (level, rate), alike in _moving_alike([model for _, model, _ in coupled], taken, waiting):
            variants = [Variant(coupled[index][0], _held(laws[index], taken[index])) for index, *_ in alike]
            moved = march(variants, level * drive, record.step / rate / every, every, orders)
            for row, indices in enumerate(alike):
                true = record.absolute(moved.probes[row], level)
                after = _conditions(laws[indices[0]], taken[indices[0]], moved, row)
                for index in indices:
                    seen = coupled[index][1].instrument.recorded_motion(names, true, record.step)
                    found[index] = RecordPrediction(seen, taken[index])
                    taken[index] = after
        waiting = [index for index in waiting if _changed(found[index].conditions, taken[index])]
        if not waiting:
            break
    return [found[index] for index in range(len(coupled))]


def _moving_alike(
    models: Sequence[CoupledModel], taken: Sequence[AmplitudesAndFrequencies], waiting: Sequence[int]
) -> Iterator[tuple[tuple[float, float], list[list[int]]]]:
    """Give models by the true level and rate of what is stated, some at once, those that differ in sensors as one.

    They are alike in pipe and clamps by identity: a change of the measuring chain leaves both in place.
    """
    marched: dict[tuple[float, float], dict[tuple[int, int, AmplitudesAndFrequencies], list[int]]] = {}
    for index in waiting:
        model = models[index]
        stretched = model.instrument.true_drive(False), model.instrument.frequency
        motion = id(model.pipe), id(model.clamps), taken[index]
        marched.setdefault(stretched, {}).setdefault(motion, []).append(index)
    for stretched, motions in marched.items():
        alike = list(motions.values())
        for begin in range(0, len(alike), MODELS_AT_ONCE):
            yield stretched, alike[begin : begin + MODELS_AT_ONCE]


def steps_between(model: CoupledModel, record: MotionRecord) -> tuple[int, RecordPrediction]:
    """Give into how many steps a sample's interval has to be cut, and what the model then says.

    Raises:
        UserError: the model can't be integrated.
    """
    for _, clamp in model.clamps[record.temperature]:
        if clamp.further:
            names = ", ".join(clamp.further)
            raise UserError(f"{record.path}: a law follows {names}; records are compared for laws of A, f and T alone")
    every, coarse = 1, _alone(model, record, 1, None)
    while True:
        fine = _alone(model, record, 2 * every, coarse.conditions)
        size = float(np.mean(fine.computed**2))
        if not math.isfinite(size):
            raise UserError(
                f"{record.path}: the model's motion grows beyond all bounds; check the excitation's unit, and the "
                "clamps' laws"
            )
        if float(np.mean((fine.computed - coarse.computed) ** 2)) <= TIME_ERROR**2 * size or 2 * every >= MOST_SUBSTEPS:
            return every, coarse
        every, coarse = 2 * every, fine


def _alone(
    model: CoupledModel, record: MotionRecord, every: int, near: AmplitudesAndFrequencies | None
) -> RecordPrediction:
    (found,) = _predicted([(_pipe(model, record), model, near)], record, every)
    return found


def _pipe(model: CoupledModel, record: MotionRecord) -> ReducedPipe:
    """Give the pipe with those clamps alone that have a law.

    Raises:
        UserError: the pipe can't be reduced.
    """
    pipe = model.reduced
    places = [index for index, _ in model.clamps[record.temperature]]
    return replace(
        pipe,
        clamp_names=tuple(pipe.clamp_names[index] for index in places),
        clamp_shapes=tuple(pipe.clamp_shapes[index] for index in places),
    )


def _held(clamps: Sequence[SteadyClamp], taken: AmplitudesAndFrequencies) -> tuple[HeldLaw, ...]:
    return tuple(
        HeldLaw(clamp.law, amplitude, frequency, clamp.temperature)
        for clamp, (amplitude, frequency) in zip(clamps, taken, strict=True)
    )


def _begun(clamp: SteadyClamp) -> tuple[float, float]:
    """Give A (mm) and f (Hz): given, or in the middle of the law's range."""
    return (
        clamp.amplitude or math.sqrt(math.prod(clamp.range_A)),
        clamp.frequency or math.sqrt(math.prod(clamp.range_f)),
    )


def _conditions(
    clamps: Sequence[SteadyClamp], taken: AmplitudesAndFrequencies, moved: MarchedModels, row: int
) -> AmplitudesAndFrequencies:
    """Give A (mm) and f (Hz) of each clamp's motion, inside the law's range; as taken where they are given."""
    found = []
    for index, clamp in enumerate(clamps):
        variance = max(float(np.var(moved.displacement[row, :, index])), 1e-30)
        speed = float(np.var(moved.velocity[row, :, index]))
        if clamp.amplitude is not None or not math.isfinite(variance + speed):
            found.append(taken[index])
            continue
        amplitude, frequency = 1e3 * math.sqrt(2 * variance), math.sqrt(speed / variance) / (2 * math.pi)
        found.append((float(np.clip(amplitude, *clamp.range_A)), float(np.clip(frequency, *clamp.range_f))))
    return tuple(found)


def _changed(before: AmplitudesAndFrequencies, after: AmplitudesAndFrequencies) -> bool:
    return any(
        abs(a / b - 1) >= SAME for new, old in zip(after, before, strict=True) for a, b in zip(new, old, strict=True)
    )
