"""The fit of the power law as an engineer would write it without pipeclamp: pandas reads, SciPy fits.

Run: python build_scripts/benchmarks/plain_script.py CAMPAIGN

Needs pandas, which pipeclamp itself does without: pip install pandas

Each run becomes 20 harmonics of displacement and force, by least squares over its whole cycles; the law (Jiang et al.
2020, Eq. 17, with its surfaces over A, f and T, 12 parameters) is fitted to all of them at once. What it doesn't do:
find cycles or their frequency, tell noise, weigh by it, check records, state uncertainties, or write a parameter file.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

HARMONICS, POINTS = 20, 512
ORDER = np.arange(HARMONICS + 1)
CELSIUS, REFERENCE = 273.15, 293.15
PARAMETERS = ("k10", "k1_A", "k1_T", "k30", "k3_A", "k3_T", "c0", "c_A", "c_f", "alpha0", "alpha_A", "alpha_f")


def harmonics_of(record, frequency):
    """Give the harmonics of displacement and force, (2, H + 1), over whole cycles, by their normal equations."""
    time = record["time_s"].to_numpy()
    step = (time[-1] - time[0]) / (len(time) - 1)
    cycles = int((time[-1] - time[0] + 1.5 * step) * frequency)
    whole = round(cycles / frequency / step)
    phase = 2 * np.pi * frequency * (time[:whole] - time[0])
    angle = np.outer(ORDER, phase)
    basis = np.vstack([np.cos(angle), -np.sin(angle[1:])])
    samples = record[["displacement_mm", "force_N"]].to_numpy()[:whole]
    solution = np.linalg.solve(basis @ basis.T, basis @ samples).T
    harmonics = solution[:, : HARMONICS + 1].astype(complex)
    harmonics[:, 1:] += 1j * solution[:, HARMONICS + 1 :]
    return harmonics * np.exp(-1j * ORDER * np.angle(harmonics[0, 1]))


def as_real(samples):
    """Give the harmonics of periodic rows as real numbers."""
    transform = np.fft.rfft(samples)[..., : HARMONICS + 1] * (2 / POINTS)
    transform[..., 0] /= 2
    return np.concatenate([transform.real, transform.imag[..., 1:]], axis=-1)


class PowerLaw:
    """Eq. 17 on measured motions."""

    def __init__(self, displacement, frequency, temperature):
        self.A, self.f, self.T = (
            np.log(ratio)[:, None] for ratio in (displacement[:, 1].real, frequency, temperature / REFERENCE)
        )
        waves = np.exp(1j * np.outer(ORDER, 2 * np.pi * np.arange(POINTS) / POINTS))
        self.y = (displacement @ waves).real
        v = 2 * np.pi * frequency[:, None] * ((1j * ORDER * displacement) @ waves).real
        speed = np.hypot(v, 0.01 * np.min(np.abs(v).max(axis=1)))
        self.direction, self.log_speed = v / speed, np.log(speed)

    def force(self, p):
        """Give the harmonics of the force."""
        k1 = p[0] * np.exp(p[1] * self.A + p[2] * self.T)
        k3 = p[3] * np.exp(p[4] * self.A + p[5] * self.T)
        c = p[6] * np.exp(p[7] * self.A + p[8] * self.f)
        alpha = p[9] * np.exp(p[10] * self.A + p[11] * self.f)
        return as_real(k1 * self.y + k3 * self.y**3 + c * np.exp(alpha * self.log_speed) * self.direction)


def main(folder):
    """Fit the law to a campaign's runs and print it."""
    runs = pd.read_csv(folder / "runs.csv")
    fitted = np.array(
        [harmonics_of(pd.read_csv(folder / run.file), run.frequency_Hz) for run in runs.itertuples(index=False)]
    )
    displacement, force = fitted[:, 0], fitted[:, 1]
    frequency = runs["frequency_Hz"].to_numpy()
    law = PowerLaw(displacement, frequency, runs["temperature_C"].to_numpy() + CELSIUS)
    measured = np.concatenate([force.real, force.imag[:, 1:]], axis=1)
    A = displacement[:, 1].real
    k1 = np.median(force[:, 1].real / A)
    c = np.median(force[:, 1].imag / np.sqrt(2 * np.pi * frequency * A))
    result = least_squares(
        lambda p: (law.force(p) - measured).ravel(),
        [k1, 0, 0, 0.1 * k1, 0, 0, c, 0, 0, 0.5, 0, 0],
        x_scale="jac",
    )
    print("  ".join(f"{name} {value:.4g}" for name, value in zip(PARAMETERS, result.x, strict=True)))
    print(f"error {np.sqrt(np.sum(result.fun**2) / np.sum(measured**2)):.2%}, {result.nfev} evaluations")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
