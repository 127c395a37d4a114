"""What refits of a coupled model are fitted to: sines, records of any motion, or both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.attribution.record_evidence import RecordEvidence
from pipeclamp_identification.attribution.sine_evidence import SineEvidence
from pipeclamp_identification.on_pipe.measurement import PipeMeasurement
from pipeclamp_identification.on_pipe.model import CoupledModel
from pipeclamp_identification.on_pipe.prediction import Prediction, predict
from pipeclamp_identification.on_pipe.record_motion import RecordPrediction, predict_record
from pipeclamp_identification.on_pipe.records import RecordPair, RecordsComparison
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError


@dataclass(frozen=True, eq=False)
class Computed:
    """What a model says of all that was measured: of the sines, if any, and of each record."""

    sines: Prediction | None
    records: tuple[RecordPrediction, ...]


@dataclass(frozen=True, eq=False)
class ModelFamily:
    """A model and such as differ from it a little, with what a model near them says."""

    models: Sequence[CoupledModel]
    near: Computed


@dataclass(frozen=True, eq=False)
class RefitTask:
    """What refits are fitted to.

    Attributes:
        model: as stated, with mounts.
        stated: what it says.
        sines: the sines, if any.
        pairs, records: the records, and what they tell.
    """

    model: CoupledModel
    stated: Computed
    sines: SineEvidence | None
    pairs: tuple[RecordPair, ...]
    records: tuple[RecordEvidence, ...]

    @property
    def measurement(self) -> PipeMeasurement | None:
        """The measured sines, if any."""
        return self.sines.measurement if self.sines else None

    def residual(self, computed: Computed) -> Array:
        """Give measured less computed values over the noise, (n,); not finite where a model has none."""
        parts = [evidence.residual(one) for evidence, one in zip(self.records, computed.records, strict=True)]
        if self.sines and computed.sines:
            parts.insert(0, self.sines.residual(computed.sines))
        return np.concatenate(parts)

    def coarse_residual(self, computed: Computed) -> Array:
        """Give what changes more steadily than the residual far from its least squares, (m,)."""
        parts = [evidence.coarse_residual(one) for evidence, one in zip(self.records, computed.records, strict=True)]
        if self.sines and computed.sines:
            parts.insert(0, self.sines.coarse_residual(computed.sines))
        return np.concatenate(parts)

    def blocks(self, number: int) -> Array:
        """Give which of about so many parts each value of the residual belongs to, (n,)."""
        evidence: list[SineEvidence | RecordEvidence] = [*([self.sines] if self.sines else []), *self.records]
        found: list[Array] = []
        for one in evidence:
            begin = found[-1].max() + 1 if found else 0.0
            found.append(begin + one.blocks(max(2, number // len(evidence))))
        return np.concatenate(found)

    def on_known_branches(self, residual: Array) -> Array:
        """Give those values of a residual (n,) whose stable motion is known, as of `SineEvidence.on_known_branches`."""
        if not self.sines:
            return residual
        known = self.sines.on_known_branches()
        return residual[np.pad(known, (0, residual.size - known.size), constant_values=True)]

    def renewed(self, near: Computed, left: float) -> RefitTask:
        """Give the task with the noise that a model that comes near shows.

        Args:
            near: what it says.
            left: its rms in units of the noise so far, which is taken where nothing else tells the noise.
        """
        sines = self.sines
        if sines and near.sines:
            sines = sines.renewed(near.sines) or sines.scaled(left)
        records = tuple(evidence.renewed(one) for evidence, one in zip(self.records, near.records, strict=True))
        return replace(self, sines=sines, records=records)

    def explained(self, by: Computed, parameters: int) -> RefitTask:
        """Give the task with the noise of its sines of which all is that a model leaves.

        Args:
            by: what it says.
            parameters: how many of it were fitted.
        """
        explained = self.sines and by.sines and self.sines.explained(by.sines, parameters)
        return replace(self, sines=explained) if explained else self

    def computed(self, families: Sequence[ModelFamily]) -> list[list[Computed | None]]:
        """Give what models say; None where one can't be built, or has no motion."""
        sines = [self._sines(family) for family in families]
        flat = [(model, family.near) for family in families for model in family.models]
        records = [
            predict_record(
                [model for model, _ in flat], pair.record, pair.every,
                [near.records[index].conditions for _, near in flat],
            )
            for index, pair in enumerate(self.pairs)
        ]  # fmt: skip
        moved = iter(list(zip(*records, strict=True)) if records else [()] * len(flat))
        found: list[list[Computed | None]] = []
        for family, of_sines in zip(families, sines, strict=True):
            found.append([])
            for _, still in zip(family.models, of_sines, strict=True):
                whole = tuple(one for one in next(moved) if one is not None)
                there = len(whole) == len(self.pairs) and (still is not None or self.sines is None)
                found[-1].append(Computed(still, whole) if there else None)
        return found

    def _sines(self, family: ModelFamily) -> list[Prediction | None]:
        """Give what each model says of the sines; the first one's steady states are near to the others'."""
        if self.sines is None:
            return [None] * len(family.models)
        found: list[Prediction | None] = []
        near = family.near.sines
        for model in family.models:
            try:
                found.append(predict(model, self.sines.measurement, near))
            except (UserError, np.linalg.LinAlgError):
                found.append(None)
            if found[0] is None:
                return [None] * len(family.models)
            near = found[0]
        return found


def task_of(model: CoupledModel, sines: SineEvidence | None, records: RecordsComparison | None) -> RefitTask:
    """Give the task of a model and what was measured; the model is taken to say what was stated with it."""
    pairs = records.pairs if records else ()
    ends = (float(records.edges[0]), float(records.edges[-1])) if records else (0.0, 0.0)
    return RefitTask(
        model,
        Computed(sines.stated if sines else None, tuple(pair.prediction for pair in pairs)),
        sines,
        pairs,
        tuple(RecordEvidence.begun(pair.record, *ends) for pair in pairs),
    )
