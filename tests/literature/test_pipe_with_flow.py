"""Pipes that carry fluid against Paidoussis (Fluid-Structure Interactions 1, chapter 3), through the described pipe.

u = U L sqrt(M/(E I)), beta = M/m. The described pipe has the beta that its fluid's density gives.
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest

from pipeclamp_models.pipe.description import PipeDescription, parse_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_models.pipe.section import beam_of

PIPE = """
name = "flow"
[pipe]
outer_diameter_mm = 60.3
wall_mm = 3.91
length_m = 5.0
material = {{ E_GPa = 200.0, density_kg_m3 = 7850.0 }}
fluid = {{ density_kg_m3 = {fluid!r} }}
[ends]
left = "{left}"
right = "{right}"
[flow]
velocity_m_s = {velocity!r}
{more}
[[clamps]]
name = "c"
position_m = 1.3
[damping]
ratio = 0.0
[modes]
up_to_Hz = 300.0
error = 0.001
"""

WALL = 7850 * (60.3**2 - 52.48**2) / 52.48**2
"""Density that a fluid needs to weigh as much as the wall, kg/m3."""


def described(left: str, right: str, beta: float, u: float, more: str = "") -> PipeDescription:
    fluid = WALL * beta / (1 - beta)
    still = parse_pipe(PIPE.format(left=left, right=right, fluid=fluid, velocity=0.0, more=more))
    beam = beam_of(still)
    assert beam.fluid_mass / beam.mass_per_length == pytest.approx(beta)
    velocity = u / beam.length * sqrt(beam.bending_stiffness / beam.fluid_mass)
    return still.model_copy(update={"flow": still.flow.model_copy(update={"velocity_m_s": velocity})})


def dimensionless(description: PipeDescription, pipe: ReducedPipe) -> tuple[float, float]:
    """Give the onset's u and the lowest frequency omega L^2 sqrt(m/(E I))."""
    beam = beam_of(description)
    assert pipe.onset is not None
    onset = pipe.onset.velocity * beam.length * sqrt(beam.fluid_mass / beam.bending_stiffness)
    scale = beam.length**2 * sqrt(beam.mass_per_length / beam.bending_stiffness)
    return onset, 2 * pi * pipe.frequencies[0] * scale if pipe.frequencies else 0.0


@pytest.mark.parametrize(
    ("left", "right", "expected"),
    [("pinned", "pinned", pi), ("clamped", "clamped", 2 * pi), ("clamped", "pinned", 4.4934)],
)
@pytest.mark.parametrize("beta", [0.2, 0.5])
def test_a_held_pipe_diverges(left: str, right: str, expected: float, beta: float) -> None:
    description = described(left, right, beta, 1.0)
    pipe = reduce(description)
    onset, _ = dimensionless(description, pipe)
    assert onset == pytest.approx(expected, rel=1e-3)
    assert pipe.onset is not None
    assert pipe.onset.kind == "divergence"
    assert pipe.stability.kind == "stable"
    beyond = reduce(described(left, right, beta, 1.005 * expected))
    assert beyond.stability.kind == "divergence"
    assert "UNSTABLE" in beyond.summary()


@pytest.mark.parametrize(("u", "expected"), [(1.0, 9.310), (2.0, 7.454), (3.0, 2.783)])
def test_the_lowest_frequency_falls_with_the_flow(u: float, expected: float) -> None:
    description = described("pinned", "pinned", 0.5, u)
    assert dimensionless(description, reduce(description))[1] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("beta", "expected"), [(0.2, 5.59), (0.5, 9.32)])
def test_a_cantilever_flutters(beta: float, expected: float) -> None:
    description = described("clamped", "free", beta, 1.0)
    pipe = reduce(description)
    onset, _ = dimensionless(description, pipe)
    assert onset == pytest.approx(expected, rel=5e-3)
    assert pipe.onset is not None
    assert pipe.onset.kind == "flutter"
    assert reduce(described("clamped", "free", beta, 1.01 * expected)).stability.kind == "flutter"


@pytest.mark.parametrize(("theta", "shear"), [(0.5, "euler"), (-2.0, "euler"), (0.5, "timoshenko")])
def test_an_axial_force_changes_frequencies_as_a_beam_column(theta: float, shear: str) -> None:
    """Pinned: omega^2 = (n pi/L)^4 E I/m (1 - P/(n^2 P_E)); with shear it buckles at P_E/(1 + P_E/(kappa G A))."""
    description = described("pinned", "pinned", 0.5, 0.0)
    description = description.model_copy(update={"pipe": description.pipe.model_copy(update={"theory": shear})})
    still = beam_of(description)
    euler = pi**2 * still.bending_stiffness / still.length**2
    loaded = description.model_copy(
        update={"axial": description.axial.model_copy(update={"tension_N": -theta * euler})}
    )
    pipe = reduce(loaded)
    assert pipe.buckling_load == pytest.approx(euler / (1 + euler / still.shear_stiffness), rel=1e-4)
    if shear == "euler":
        unloaded = sqrt(still.bending_stiffness / still.mass_per_length) / still.length**2
        expected = [(n * pi) ** 2 * unloaded * sqrt(1 - theta / n**2) / (2 * pi) for n in (1, 2, 3)]
        assert pipe.frequencies[:3] == pytest.approx(expected, rel=1e-4)


def timoshenko(n: int, description: PipeDescription) -> float:
    """Give the n-th frequency in Hz of a simply supported Timoshenko beam: the lower root of its quadratic in omega^2.

    m J omega^4/(kappa G A) - (m + k^2 (J + m E I/(kappa G A))) omega^2 + E I k^4 = 0 with k = n pi/L, J the section's
    rotary inertia per length.
    """
    beam = beam_of(description)
    k, m, J = n * pi / beam.length, beam.mass_per_length, beam.rotary_inertia
    bending, shear = beam.bending_stiffness, beam.shear_stiffness
    roots = np.roots([m * J / shear, -(m + k**2 * (J + m * bending / shear)), bending * k**4])
    return float(np.sqrt(roots.min()) / (2 * pi))


@pytest.mark.parametrize("length", [0.4, 1.0, 5.0])
def test_a_simply_supported_timoshenko_beam(length: float) -> None:
    description = described("pinned", "pinned", 0.2, 0.0)
    table = description.pipe.model_copy(update={"theory": "timoshenko", "length_m": length})
    short = description.model_copy(
        update={
            "pipe": table,
            "clamps": (),
            "modes": description.modes.model_copy(update={"up_to_Hz": 3e4 * 0.16 / length**2}),
        }
    )
    found = reduce(short).frequencies
    expected = [timoshenko(n, short) for n in range(1, 4)]
    assert found[:3] == pytest.approx(expected, rel=1e-3)
    if length < 1.0:  # where it matters: Euler-Bernoulli is far off
        slender = reduce(short.model_copy(update={"pipe": table.model_copy(update={"theory": "euler"})}))
        assert slender.frequencies[0] > 1.05 * expected[0]
