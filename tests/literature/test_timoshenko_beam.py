"""A thick pipe with shear and rotary inertia against the closed form of a pinned beam, all modes of the band.

S. P. Timoshenko, On the correction for shear of the differential equation for transverse vibrations of prismatic bars,
Philosophical Magazine 41 (1921) 744-746: w = sin(n pi x/L), and the section's rotation as its cosine.
"""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from scipy.linalg import expm

from pipeclamp_models.pipe.beam import modes
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import finite_elements
from pipeclamp_models.pipe.section import beam_of

PIPE = """
name = "thick"
[pipe]
outer_diameter_mm = {diameter}
wall_mm = 8.0
length_m = {length}
material = {{ E_GPa = 200.0, density_kg_m3 = 7850.0 }}
theory = "timoshenko"
[ends]
left = "{left}"
right = "{right}"
[[clamps]]
name = "clamp1"
position_m = {clamp}
[damping]
ratio = 0.01
[modes]
up_to_Hz = {up_to_Hz}
"""


def modes_of(diameter, length, up_to_Hz, left="pinned", right="pinned"):
    """The beam of a pipe, and its angular frequencies in the band, rad/s."""
    description = parse_pipe(
        PIPE.format(diameter=diameter, length=length, clamp=0.37 * length, up_to_Hz=up_to_Hz, left=left, right=right)
    )
    beam = beam_of(description)
    omega, _ = modes(beam, finite_elements(description))
    inside = omega[omega <= 2 * pi * up_to_Hz]
    assert len(inside) >= 6
    return beam, inside


@pytest.mark.parametrize(
    ("diameter", "length", "up_to_Hz"), [(323.9, 4.0, 1500.0), (219.1, 3.0, 2000.0), (60.3, 6.0, 400.0)]
)
def test_every_mode_of_the_band_has_the_closed_form_s_frequency(diameter, length, up_to_Hz):
    beam, inside = modes_of(diameter, length, up_to_Hz)
    squared = (np.arange(1, len(inside) + 1) * pi / length) ** 2
    # (S k^2 - m w^2)(E I k^2 + S - J w^2) = S^2 k^2, the lower root.
    m, J, S, bending = beam.mass_per_length, beam.rotary_inertia, beam.shear_stiffness, beam.bending_stiffness
    b = m * (bending * squared + S) + J * S * squared
    exact = np.sqrt((b - np.sqrt(b**2 - 4 * m * J * S * bending * squared**2)) / (2 * m * J))
    assert inside == pytest.approx(exact, rel=1e-5)


HELD = {"clamped": [0, 1], "pinned": [0, 2], "free": [2, 3]}
"""Which of displacement, rotation, moment and shear force vanish at an end."""


def frequency_equation(beam, left, right, omega):
    """The determinant that vanishes at a natural frequency, by the beam's transfer matrix over its whole length.

    w' = psi + Q/S, psi' = M/(E I), M' = -Q - J omega^2 psi, Q' = -m omega^2 w.
    """
    m, J, S, bending = beam.mass_per_length, beam.rotary_inertia, beam.shear_stiffness, beam.bending_stiffness
    slopes = np.array([[0, 1, 0, 1 / S], [0, 0, 1 / bending, 0], [0, -J * omega**2, 0, -1], [-m * omega**2, 0, 0, 0]])
    units = np.array([1.0, 1 / beam.length, bending / beam.length**2, bending / beam.length**3])
    across = expm(slopes * beam.length) * units / units[:, None]
    return np.linalg.det(across[np.ix_(HELD[right], [n for n in range(4) if n not in HELD[left]])])


@pytest.mark.parametrize(("left", "right"), [("clamped", "clamped"), ("clamped", "free"), ("clamped", "pinned")])
@pytest.mark.parametrize(("diameter", "length", "up_to_Hz"), [(323.9, 4.0, 2000.0), (60.3, 6.0, 400.0)])
def test_with_other_ends_the_frequency_equation_vanishes_within_a_hundred_thousandth(
    diameter, length, up_to_Hz, left, right
):
    beam, inside = modes_of(diameter, length, up_to_Hz, left, right)
    for omega in inside[:6]:
        below, above = (frequency_equation(beam, left, right, omega * (1 + aside)) for aside in (-1e-5, 1e-5))
        assert below * above < 0, f"{omega / (2 * pi)} Hz"
