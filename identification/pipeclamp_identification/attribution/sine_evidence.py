"""What sines tell of a coupled model: measured less computed response at each sine and probe, over its noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.attribution.noise import first_guess, likeliest_noise, misfit_noise
from pipeclamp_identification.on_pipe.measurement import PipeMeasurement
from pipeclamp_identification.on_pipe.prediction import Prediction
from pipeclamp_identification.on_pipe.series import series_of
from pipeclamp_identification.on_pipe.sines import turned_error
from pipeclamp_models.base.arrays import Array, BoolArray

BURIED = 10.0
"""A response of fewer times its noise counts little in a first approach."""


@dataclass(frozen=True, eq=False)
class SineEvidence:
    """Sines that refits are fitted to.

    Attributes:
        measurement: what was measured.
        stated: what the model as stated says.
        noise: standard deviation of real and of imaginary part of each response, (P, probes).
    """

    measurement: PipeMeasurement
    stated: Prediction
    noise: Array

    @classmethod
    def begun(cls, measurement: PipeMeasurement, stated: Prediction) -> SineEvidence:
        """Give it with a first guess of the noise."""
        return cls(measurement, stated, first_guess(measurement))

    def renewed(self, near: Prediction) -> SineEvidence | None:
        """Give it with the noise that a model that comes near shows; None where nothing tells the noise."""
        noise = misfit_noise(self.measurement, near.response)
        return None if noise is None else replace(self, noise=noise)

    def explained(self, near: Prediction, parameters: int) -> SineEvidence:
        """Give it with the noise of which all is that a model leaves, so many parameters of which were fitted."""
        return replace(self, noise=likeliest_noise(self.measurement, near.response, parameters))

    def scaled(self, factor: float) -> SineEvidence:
        """Give it with another noise."""
        return replace(self, noise=factor * self.noise)

    def residual(self, prediction: Prediction) -> Array:
        """Give measured less computed over the noise; not finite where a steady state is missing that was there."""
        error = turned_error(self.measurement, prediction.response) / self.noise
        return self._flat(error.real, error.imag)

    def coarse_residual(self, prediction: Prediction) -> Array:
        """Give the logarithm of measured over computed response where `residual` gives their difference.

        A resonance that is moved by several times its width changes it steadily, where differences have many valleys.
        """
        steady = self.measurement.steady
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.log(steady.response / prediction.response)
            above_noise = np.abs(steady.response) / (np.abs(steady.response) + BURIED * self.noise)
        ratio *= above_noise
        return self._flat(ratio.real, ratio.imag)

    def on_known_branches(self) -> BoolArray:
        """Tell which values are of a known motion: where there are several stable ones, the sweep says which."""
        steady = self.measurement.steady
        known = (self.stated.branches == 1) | (steady.sweep != 0)
        of_rows = np.broadcast_to(known[:, None], steady.response.shape).astype(np.float64)
        return self._flat(of_rows, of_rows) > 0

    def blocks(self, number: int) -> Array:
        """Give which of some parts each value belongs to: neighbouring frequencies of a series, all probes."""
        steady = self.measurement.steady
        block = np.zeros(steady.frequency.size)
        series = series_of(steady)
        each = max(1, round(number / len(series)))
        for index, one in enumerate(series):
            block[one.rows] = index * each + np.arange(one.rows.size) * each // one.rows.size
        of_rows = np.broadcast_to(block[:, None], steady.response.shape)
        return self._flat(of_rows, of_rows)

    def _flat(self, real: Array, imaginary: Array) -> Array:
        """Give what belongs to real and to imaginary parts, (P, probes) each, in the order of the residual, (n,)."""
        steady = self.measurement.steady
        compared = np.isfinite(steady.response) & np.isfinite(self.stated.response)
        return np.concatenate([real[compared], imaginary[compared & steady.phased]])
