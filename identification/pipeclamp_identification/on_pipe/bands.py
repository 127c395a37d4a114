"""Whether what was measured on a pipe lies in the band of its model: how sure each computed sine is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeclamp_identification.on_pipe.answer import BandsOnPipeAnswer
from pipeclamp_identification.on_pipe.measurement import read_measurement_description
from pipeclamp_identification.on_pipe.prediction import Group
from pipeclamp_identification.on_pipe.sines import PipeComparison, sine_scatter_of
from pipeclamp_models.base.arrays import Array, BoolArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_system.bands.band import steps_of
from pipeclamp_system.bands.described import refuse_unknown, unknown_of
from pipeclamp_system.bands.quantities import Unknown
from pipeclamp_system.bands.sensitivity import moves_at, with_laws
from pipeclamp_system.bands.varied import gaps
from pipeclamp_system.description.system import read_system


@dataclass(frozen=True, eq=False)
class PipeBands:
    """The bands of a comparison at sines.

    Attributes:
        comparison: the model against what was measured.
        per_cent: that each band holds.
        low, high: of amplitudes over the drive, as of `PipeComparison`, nan where nothing is computed, (P, probes).
        gaps: what the laws' files don't tell, in words.
    """

    comparison: PipeComparison
    per_cent: float
    low: Array
    high: Array
    gaps: tuple[str, ...]

    @property
    def outside(self) -> BoolArray:
        """Which measured amplitudes lie outside their band, (P, probes)."""
        measured = np.abs(self.comparison.measurement.steady.response)
        return np.asarray(self.comparison.compared & ((measured < self.low) | (measured > self.high)))

    @property
    def share(self) -> float:
        """Share of the measured amplitudes that lie outside."""
        return float(self.outside.sum()) / float(self.comparison.compared.sum())

    @property
    def half_width(self) -> float:
        """Median of half a band, as a share of the computed amplitude."""
        compared = self.comparison.compared
        size = np.abs(self.comparison.prediction.response)
        return float(np.median(((self.high - self.low) / 2)[compared] / np.maximum(size[compared], 1e-300)))

    def words(self) -> list[str]:
        """Say how much of what was measured lies in the band."""
        number, count = int(self.outside.sum()), int(self.comparison.compared.sum())
        lines = [
            f"{number} of {count} measured amplitudes ({self.share:.0%}) lie outside the model's {self.per_cent:g}% "
            f"band, {100 - self.per_cent:g}% would by chance; half the band is {self.half_width:.1%} of the "
            "amplitude (median)."
        ]
        if not np.isfinite(self._scatter()).any():
            lines.append("The sensors' scatter isn't known: the band is the model's alone.")
        return [*lines, *self.gaps]

    def answer(self) -> BandsOnPipeAnswer:
        """Give it for --json."""
        return BandsOnPipeAnswer(
            per_cent=self.per_cent,
            compared=int(self.comparison.compared.sum()),
            outside=int(self.outside.sum()),
            share_outside=self.share,
            half_width=self.half_width,
        )

    def _scatter(self) -> Array:
        return sine_scatter_of(self.comparison.measurement)


def refuse_bands(path: Path, measured: Path, per_cent: float) -> None:
    """Refuse what no band can be given of, before anything is computed.

    Raises:
        UserError: a file can't be read, nothing but records was measured, or no law tells how sure it is.
        UsageError: the share can't be held by a band.
    """
    steps_of(per_cent)
    refuse_unknown(read_system(path), path.parent, str(path))
    if not read_measurement_description(measured)[1].has_sines:
        raise UserError(
            f"{measured}: only records of any motion; bands are of sines: leave out --bands, or pipeclamp cosim --bands"
        )


def pipe_bands(path: Path, comparison: PipeComparison, per_cent: float) -> PipeBands:
    """Give the bands of a model at the sines that were measured, to first order, the sensors' scatter among them.

    Args:
        path: SYSTEM.toml, whose model was compared.
        comparison: of it with sines.
        per_cent: that each band holds, such as 95.

    Raises:
        UserError: a law can't be read.
        UsageError: the share can't be held by a band.
    """
    steps = steps_of(per_cent)
    unknown = unknown_of(comparison.system, path.parent)
    shape = comparison.measurement.steady.response.shape
    variance, moved = np.full(shape, np.nan), np.zeros(shape)
    for group in comparison.prediction.groups:
        for place, row in enumerate(group.rows.tolist()):
            if group.solved.found[place]:
                slopes = _slopes(comparison, group, place, row, unknown)
                moved[row] = unknown.means @ slopes
                variance[row] = np.einsum("qp,qr,rp->p", slopes, unknown.covariance, slopes)
    variance += np.nan_to_num(sine_scatter_of(comparison.measurement)) ** 2
    half, size = steps * np.sqrt(variance), np.abs(comparison.prediction.response) + moved
    return PipeBands(comparison, per_cent, np.maximum(size - half, 0.0), size + half, gaps(unknown.laws))


def _slopes(comparison: PipeComparison, group: Group, place: int, row: int, unknown: Unknown) -> Array:
    """Give the derivatives of the amplitudes that the probes show at one sine over its drive, (Q, probes)."""
    model, steady = comparison.model, comparison.measurement.steady
    frequency, drive = float(steady.frequency[row]), float(steady.drive[row])
    system = model.system(group.temperature, lambda _: drive, group.harmonics)
    state = system.state(group.solved.unknowns[place], frequency)
    clamps = with_laws([clamp for _, clamp in model.clamps[group.temperature]], unknown)
    # the excitation is drive sin(2 pi f t), harmonics are of Re Y e^(i 2 pi f t)
    changes = 1e-3 * moves_at(system, clamps, state, unknown)[:, len(clamps) :, 1] / (-1j * drive)
    turn = 2j * np.pi * frequency
    changes = changes * np.array([turn**probe.order for probe in comparison.measurement.description.probes])
    response = comparison.prediction.response[row]
    return np.asarray(np.real(changes * np.conj(response)) / np.abs(response))
