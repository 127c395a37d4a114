"""Eigenvalues of the described pipe against the closed forms of the Euler-Bernoulli beam (Blevins, table 8-1)."""

from __future__ import annotations

from math import pi, tan, tanh

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from pipeclamp_models.pipe.description import PipeDescription, parse_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, beam_of, finite_elements, reduce

PIPE = """
name = "beam"
[pipe]
outer_diameter_mm = 60.3
wall_mm = 3.91
length_m = 5.0
material = {{ E_GPa = 200.0, density_kg_m3 = 7850.0 }}
fluid = "water"
[ends]
left = {left}
right = {right}
{more}
[damping]
ratio = 0.0
[modes]
up_to_Hz = {up_to}
"""


def pipe(left: str, right: str, more: str = "", up_to: float = 200.0) -> PipeDescription:
    return parse_pipe(PIPE.format(left=left, right=right, more=more, up_to=up_to))


def eigenvalues(description: PipeDescription) -> np.ndarray:
    """Give lambda = beta L of the kept modes."""
    reduced: ReducedPipe = reduce(description)
    scale = reduced.mass_per_length * description.pipe.length_m**4 / reduced.bending_stiffness
    return np.array([(omega**2 * scale) ** 0.25 for omega in reduced.omega[: reduced.kept]])


@pytest.mark.parametrize(
    ("left", "right", "expected"),
    [
        ('"clamped"', '"free"', [1.87510407, 4.69409113, 7.85475744]),
        ('"pinned"', '"pinned"', [pi, 2 * pi, 3 * pi, 4 * pi]),
        ('"clamped"', '"clamped"', [4.73004074, 7.85320462]),
        ('"clamped"', '"pinned"', [3.92660231, 7.06858275]),
        ('"guided"', '"pinned"', [pi / 2, 3 * pi / 2]),
        ('"free"', '"free"', [0.0, 0.0, 4.73004074, 7.85320462]),
        ('"guided"', '"guided"', [0.0, pi, 2 * pi]),
    ],
)
def test_eigenvalues(left: str, right: str, expected: list[float]) -> None:
    assert eigenvalues(pipe(left, right))[: len(expected)] == pytest.approx(expected, rel=1e-4, abs=1e-9)


def test_the_highest_kept_mode_is_converged_too() -> None:
    found = eigenvalues(pipe('"pinned"', '"pinned"', up_to=2000.0))
    assert len(found) >= 12
    assert found == pytest.approx(pi * np.arange(1, len(found) + 1), rel=1e-4)


def test_spans_of_a_continuous_pipe_are_the_single_span() -> None:
    """Three equal spans on pinned supports vibrate, lowest, as one pinned span of a third of the length."""
    supports = "".join(f'[[supports]]\nposition_m = {x!r}\ncondition = "pinned"\n' for x in (5 / 3, 10 / 3))
    assert eigenvalues(pipe('"pinned"', '"pinned"', supports, up_to=400.0))[0] == pytest.approx(3 * pi, rel=1e-4)


@pytest.mark.parametrize("kappa", [1e-3, 1.0, 30.0, 300.0, 900.0, 995.0, 997.0, 2000.0, 1e6])
def test_a_spring_at_midspan_walks_the_first_frequency(kappa: float) -> None:
    """k = kappa E I/L^3. Symmetric: tan a - tanh a = -32 a^3/kappa, a = lambda/2; antisymmetric modes don't see it."""
    plain = pipe('"pinned"', '"pinned"')
    beam = beam_of(plain)
    k = kappa * beam.bending_stiffness / beam.length**3
    spring = f"[[supports]]\nposition_m = 2.5\ncondition = {{ stiffness_N_mm = {k / 1e3!r} }}\n"
    symmetric = 2 * brentq(
        lambda a: kappa * (tan(a) - tanh(a)) + 32 * a**3, pi / 2 * (1 + 1e-12), 3 * pi / 2 * (1 - 1e-12), xtol=1e-13
    )
    found = eigenvalues(pipe('"pinned"', '"pinned"', spring))
    assert found[0] == pytest.approx(min(symmetric, 2 * pi), rel=1e-4)
    assert found[:2] == pytest.approx(sorted([symmetric, 2 * pi]), rel=1e-4)


def test_a_mass_at_midspan_lowers_the_first_frequency() -> None:
    """Symmetric modes with a mass M = mu m L at midspan: tan a - tanh a = 2/(mu a)."""
    plain = pipe('"pinned"', '"pinned"')
    beam = beam_of(plain)
    mu = 0.7
    mass = mu * beam.mass_per_length * beam.length
    expected = 2 * brentq(lambda a: mu * a * (tan(a) - tanh(a)) - 2, 0.1, pi / 2 * (1 - 1e-12))
    more = f"[[masses]]\nposition_m = 2.5\nmass_kg = {mass!r}\n"
    assert eigenvalues(pipe('"pinned"', '"pinned"', more))[0] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("position", [1.1, 2.5, 5.0])
def test_a_clamp_ten_times_as_stiff_as_the_pipe_is_right_in_the_reduced_model(position: float) -> None:
    """The reduced model with a spring at its clamp against the finite elements with the same spring."""
    description = pipe('"clamped"', '"free"', f'[[clamps]]\nname = "c"\nposition_m = {position}\n', up_to=120.0)
    assembly = finite_elements(description)
    row = assembly.displacement_at(position)
    k = 10.0 / float(row @ np.linalg.solve(assembly.stiffness, row))
    exact = np.sqrt(eigh(assembly.stiffness + k * np.outer(row, row), assembly.mass, eigvals_only=True))
    reduced = reduce(description)
    shape = np.array(reduced.clamp_shapes[0])
    stiffness = np.diag(np.array(reduced.omega) ** 2)
    inside = exact[exact < 2 * pi * 60.0]
    assert len(inside) >= 2

    found = np.sqrt(np.linalg.eigvalsh(stiffness + k * np.outer(shape, shape)))[: len(inside)]
    kept = reduced.kept
    bare = np.sqrt(np.linalg.eigvalsh((stiffness + k * np.outer(shape, shape))[:kept, :kept]))[: len(inside)]
    error, error_without = np.abs(found / inside - 1).max(), np.abs(bare / inside - 1).max()
    assert error < 1e-3
    assert error < error_without / 3  # it is the residual mode that does it
