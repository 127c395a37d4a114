"""A thick pipe with shear and rotary inertia against the closed form of a pinned beam, all modes of the band.

S. P. Timoshenko, On the correction for shear of the differential equation for transverse vibrations of prismatic bars,
Philosophical Magazine 41 (1921) 744-746: w = sin(n pi x/L), and the section's rotation as its cosine.
"""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from pipeclamp_models.pipe.beam import SHEAR_ERROR, modes
from pipeclamp_models.pipe.description import read_pipe
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
left = "pinned"
right = "pinned"
[[clamps]]
name = "clamp1"
position_m = {clamp}
[damping]
ratio = 0.01
[modes]
up_to_Hz = {up_to_Hz}
"""


@pytest.mark.parametrize(
    ("diameter", "length", "up_to_Hz"), [(323.9, 4.0, 1500.0), (219.1, 3.0, 2000.0), (60.3, 6.0, 400.0)]
)
def test_every_mode_of_the_band_has_the_closed_form_s_frequency(diameter, length, up_to_Hz, tmp_path):
    text = PIPE.format(diameter=diameter, length=length, clamp=0.37 * length, up_to_Hz=up_to_Hz)
    (tmp_path / "pipe.toml").write_text(text, encoding="utf-8")
    description = read_pipe(tmp_path / "pipe.toml")
    beam = beam_of(description)
    omega, _ = modes(beam, finite_elements(description))
    inside = omega[omega <= 2 * pi * up_to_Hz]
    assert len(inside) >= 6
    squared = (np.arange(1, len(inside) + 1) * pi / length) ** 2
    # (S k^2 - m w^2)(E I k^2 + S - J w^2) = S^2 k^2, the lower root.
    m, J, S, bending = beam.mass_per_length, beam.rotary_inertia, beam.shear_stiffness, beam.bending_stiffness
    b = m * (bending * squared + S) + J * S * squared
    exact = np.sqrt((b - np.sqrt(b**2 - 4 * m * J * S * bending * squared**2)) / (2 * m * J))
    assert inside == pytest.approx(exact, rel=SHEAR_ERROR)
