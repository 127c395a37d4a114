"""A coupled model held against all that was measured on the pipe: sines, records of any motion, or both."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

from pipeclamp_identification.attribution.task import Computed
from pipeclamp_identification.on_pipe.measurement import MeasurementDescription, read_measurement_description
from pipeclamp_identification.on_pipe.model import CoupledModel
from pipeclamp_identification.on_pipe.records import RecordsComparison, compare_records
from pipeclamp_identification.on_pipe.sines import PipeComparison, compare_pipe
from pipeclamp_system.description.system import SystemDescription


@dataclass(frozen=True, eq=False)
class Compared:
    """A coupled model held against a measurement.

    Attributes:
        sines, records: the comparisons; one of them may be missing.
    """

    sines: PipeComparison | None = None
    records: RecordsComparison | None = None

    @property
    def _parts(self) -> list[PipeComparison | RecordsComparison]:
        return [one for one in (self.sines, self.records) if one is not None]

    @property
    def system(self) -> SystemDescription:
        """The system as described."""
        return self._parts[0].system

    @property
    def description(self) -> MeasurementDescription:
        """The measurement as described."""
        if self.sines:
            return self.sines.measurement.description
        assert self.records
        return self.records.description

    @property
    def model(self) -> CoupledModel:
        """Pipe and clamps, at all temperatures that were measured at."""
        clamps = {key: value for one in self._parts for key, value in one.model.clamps.items()}
        return replace(self._parts[0].model, clamps=clamps)

    @property
    def nrmse(self) -> float:
        """Error of the model as stated; of sines and of records by its mean square."""
        return math.sqrt(sum(one.nrmse**2 for one in self._parts) / len(self._parts))

    def saying(self, computed: Computed) -> Compared:
        """Give the comparison with what another model says."""
        sines = replace(self.sines, prediction=computed.sines) if self.sines and computed.sines else None
        return Compared(sines, self.records and self.records.saying(computed.records))


def compare_measured(system: Path, measured: Path) -> Compared:
    """Hold the coupled model of a system's file against a measurement.

    Raises:
        UserError: a file can't serve, they don't belong together, or the model has no motion to compare.
    """
    _, description = read_measurement_description(measured)
    return Compared(
        compare_pipe(system, measured) if description.has_sines else None,
        compare_records(system, measured) if description.records else None,
    )
