"""What a record of any motion tells of a coupled model, counted in cells: a part of time, a band of frequency, a probe.

Samples are no evidence by themselves: neighbouring ones err alike. A record is cut into parts of time, each tapered and
transformed, and its lines into bands. In a cell, measured and computed lines differ by a factor, as two phasors of a
sine do, and by what is incoherent with the motion. The first gives two values, an amplitude's and a phase's; the second
is noise, and tells the first one's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal.windows import tukey

from pipeclamp_identification.attribution.noise import FIRST_GUESS, MODEL_ERROR, TRUSTED_SHARE
from pipeclamp_identification.attribution.sine_evidence import BURIED
from pipeclamp_identification.on_pipe.record_files import MotionRecord
from pipeclamp_identification.on_pipe.record_motion import RecordPrediction
from pipeclamp_models.base.arrays import Array, BoolArray, ComplexArray

LINES = 6
"""Of a band; all but about one of them tell the noise."""
FEWEST_BANDS = 4
FEWEST_CYCLES_A_PART, MOST_PARTS = 10, 8
"""A part of time holds so many cycles of the lowest frequency at least; and there are so many parts at most."""
TAPER = 0.5
"""Share of a part's time over which it is faded in and out."""
LEAST_SIGNAL = 0.01
"""Share of a probe's largest cell below which a cell says nothing."""


@dataclass(frozen=True)
class Cells:
    """How a record is cut.

    Attributes:
        parts, samples: how many parts of time, and samples in each.
        first, bands: the first line, and how many bands follow from it.
    """

    parts: int
    samples: int
    first: int
    bands: int

    @property
    def likeness(self) -> float:
        """How many of a band's lines noise and motion share, 1 without a taper, which makes neighbouring lines alike.

        It is the sum of the squared correlations of all pairs of lines over their number.
        """
        spectrum = np.abs(np.fft.fft(tukey(self.samples, TAPER) ** 2)[:LINES])
        squared = (spectrum / spectrum[0]) ** 2
        pairs = np.concatenate([[LINES], 2.0 * np.arange(LINES - 1, 0, -1)])
        return float(np.sum(pairs * squared) / LINES)

    def lines(self, values: Array) -> ComplexArray:
        """Give the lines of a record, (n, probes), by part, band, place in the band and probe."""
        cut = values[: self.parts * self.samples].reshape(self.parts, self.samples, -1)
        spectra = np.fft.rfft(cut * tukey(self.samples, TAPER)[:, None], axis=1)
        chosen = spectra[:, self.first : self.first + self.bands * LINES]
        return np.asarray(chosen.reshape(self.parts, self.bands, LINES, -1), dtype=np.complex128)


def cells_of(record: MotionRecord, low: float, high: float) -> Cells:
    """Cut a record whose motion lies between two frequencies, Hz."""
    duration, size = float(record.time[-1]), record.time.size
    by_band = int((high - low) * duration / (LINES * FEWEST_BANDS))
    parts = max(1, min(int(low * duration / FEWEST_CYCLES_A_PART), by_band, MOST_PARTS))
    samples = size // parts
    first = max(1, int(low * samples * record.step))
    last = min(int(np.ceil(high * samples * record.step)), samples // 2)
    return Cells(parts, samples, first, max(1, (last + 1 - first) // LINES))


@dataclass(frozen=True, eq=False)
class RecordEvidence:
    """A record that refits are fitted to.

    Attributes:
        cells: how it is cut.
        measured: its lines.
        along: unit vectors over the lines of each cell, along which measured and computed ones are compared.
        noise: standard deviation of each part of a cell's error, (parts, bands, probes).
        used: cells that hold a signal, likewise.
    """

    cells: Cells
    measured: ComplexArray
    along: ComplexArray
    noise: Array
    used: BoolArray

    @classmethod
    def begun(cls, record: MotionRecord, low: float, high: float) -> RecordEvidence:
        """Give it with a first guess of the noise, for a record whose motion lies between two frequencies, Hz."""
        cells = cells_of(record, low, high)
        measured = cells.lines(record.measured)
        size = _norm(measured)
        largest = size.max(axis=(0, 1))
        floor, share = FIRST_GUESS
        noise = np.hypot(floor * largest, share * size)
        used = size > LEAST_SIGNAL * largest
        return cls(cells, measured, _along(measured), np.where(used, noise, 1.0), used)

    def renewed(self, near: RecordPrediction) -> RecordEvidence:
        """Give it with the noise that a model that comes near shows, and compared along what that model says.

        Measured lines hold noise: along themselves, noise would look like an error of amplitude.
        """
        computed = self.cells.lines(near.computed)
        along = _along(computed)
        error = self.measured - computed
        coherent = np.abs(np.sum(np.conj(along) * error, axis=2)) ** 2
        incoherent = np.sum(np.abs(error) ** 2, axis=2) - coherent
        # Noise is the same in all parts of the record; half of it lies in the real part.
        alike = self.cells.likeness
        variance = alike / (LINES - alike) * np.mean(incoherent, axis=0)
        size = _norm(self.measured)
        noise = np.sqrt(variance / 2 + (MODEL_ERROR * size) ** 2 + (TRUSTED_SHARE * size.max(axis=(0, 1))) ** 2)
        return replace(self, along=along, noise=np.where(self.used, noise, 1.0))

    def residual(self, prediction: RecordPrediction) -> Array:
        """Give measured less computed amplitude and phase of each cell over the noise, (n,)."""
        error = self.measured - self.cells.lines(prediction.computed)
        turned = np.sum(np.conj(self.along) * error, axis=2)[self.used] / self.noise[self.used]
        return np.concatenate([turned.real, turned.imag])

    def coarse_residual(self, prediction: RecordPrediction) -> Array:
        """Give the logarithm of measured over computed rms of each band; it follows a resonance however far it is."""
        bands = np.any(self.used, axis=0)
        measured, computed, noise = (
            np.sqrt(np.sum(np.where(self.used, values, 0.0) ** 2, axis=0))[bands]
            for values in (_norm(self.measured), _norm(self.cells.lines(prediction.computed)), self.noise)
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.log(measured / computed) * measured / (measured + BURIED * noise))

    def blocks(self, number: int) -> Array:
        """Give which of some parts each value belongs to: neighbouring bands, all probes and times."""
        of_bands = np.arange(self.cells.bands) * number // self.cells.bands
        labels = np.broadcast_to(of_bands[None, :, None], self.used.shape)[self.used].astype(np.float64)
        return np.concatenate([labels, labels])


def _norm(lines: ComplexArray) -> Array:
    """Give the size of each cell, (parts, bands, probes)."""
    return np.asarray(np.sqrt(np.sum(np.abs(lines) ** 2, axis=2)))


def _along(lines: ComplexArray) -> ComplexArray:
    size = _norm(lines)[:, :, None]
    return np.asarray(lines / np.where(size > 0, size, 1.0))
