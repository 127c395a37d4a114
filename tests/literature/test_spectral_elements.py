"""A pipe's frequency response against spectral elements: the beam's own waves in closed form, no modes.

J. F. Doyle, Wave Propagation in Structures, 2nd ed., Springer 1997: between nodes the deflection is the sum of
exp(+-i k x) and exp(+-k x), k^4 = omega^2 m/(E I). Damping alpha M + beta K turns E I and springs by 1 + i omega beta,
and m by 1 - i alpha/omega.
"""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce

LENGTH, SUPPORT, UP_TO = 50.0, 5e3, 50.0
CLAMP, PROBE, FORCE = 12.0, 31.0, 41.0
ALPHA, BETA = 0.3, 2e-5
PIPE = f"""
name = "long"
pipe = {{ outer_diameter_mm = 60.3, wall_mm = 3.91, length_m = {LENGTH}, material = "316L", fluid = "water" }}
ends = {{ left = {{ stiffness_N_mm = {SUPPORT / 1e3} }}, right = {{ stiffness_N_mm = {SUPPORT / 1e3} }} }}
clamps = [{{ name = "clamp", position_m = {CLAMP} }}]
probes = [{{ name = "probe", position_m = {PROBE} }}]
excitation = {{ kind = "force", position_m = {FORCE} }}
damping = {{ rayleigh_alpha_1_s = {ALPHA}, rayleigh_beta_s = {BETA} }}
modes = {{ up_to_Hz = {UP_TO} }}
"""


def spectral_element(bending: complex, wave_number: complex, length: float) -> np.ndarray:
    """Give forces and moments over displacements and slopes of an element's ends, (4, 4)."""
    waves = wave_number * np.array([1j, -1j, 1.0, -1.0])
    start, end = np.ones(4), np.exp(waves * length)
    motion = np.array([start, waves, end, waves * end])
    load = bending * np.array([waves**3, -(waves**2), -(waves**3) * end, waves**2 * end])
    return load @ np.linalg.inv(motion)


def probe_by_waves(pipe: ReducedPipe, clamp: float, omega: Array) -> np.ndarray:
    """Give the displacement of the probe per newton at the force, m/N, with a spring at the clamp (N/m)."""
    nodes = np.arange(0.0, LENGTH + 1)
    found = []
    for one in omega:
        turned = 1 + 1j * one * BETA
        bending = pipe.bending_stiffness * turned
        wave_number = (one**2 * pipe.mass_per_length * (1 - 1j * ALPHA / one) / bending) ** 0.25
        element = spectral_element(bending, wave_number, 1.0)
        whole = np.zeros((2 * nodes.size, 2 * nodes.size), dtype=complex)
        for index in range(nodes.size - 1):
            own = slice(2 * index, 2 * index + 4)
            whole[own, own] += element
        for place, spring in ((0.0, SUPPORT * turned), (LENGTH, SUPPORT * turned), (CLAMP, clamp)):
            whole[2 * int(place), 2 * int(place)] += spring
        load = np.zeros(2 * nodes.size)
        load[2 * int(FORCE)] = 1.0
        found.append(np.linalg.solve(whole, load)[2 * int(PROBE)])
    return np.array(found)


def probe_by_modes(pipe: ReducedPipe, clamp: float, omega: Array) -> np.ndarray:
    """Give the same of the reduced pipe."""
    at_clamp, at_probe = np.array(pipe.clamp_shapes[0]), np.array(pipe.probe_shapes[0])
    stiffness = np.diag(np.square(pipe.omega)) + clamp * np.outer(at_clamp, at_clamp)
    dynamic = [stiffness - w**2 * np.eye(len(stiffness)) + 1j * w * np.diag(pipe.damping) for w in omega]
    return np.array([at_probe @ np.linalg.solve(one, pipe.excitation_participation) for one in dynamic])


@pytest.mark.parametrize("clamp", [0.0, 1e6, 1e9])
def test_the_stated_error_holds_at_every_frequency_and_with_any_clamp(clamp: float) -> None:
    """Mean square over each twentieth of the band: what is small there isn't hidden by what is large elsewhere."""
    pipe = reduce(parse_pipe(PIPE))
    assert max(pipe.errors.response, pipe.errors.clamped) <= 0.01
    omega = 2 * pi * np.linspace(1.0, UP_TO, 20 * 16)
    exact, found = (answer(pipe, clamp, omega).reshape(20, -1) for answer in (probe_by_waves, probe_by_modes))
    errors = np.sqrt(np.mean(np.abs(found - exact) ** 2, axis=1) / np.mean(np.abs(exact) ** 2, axis=1))
    assert errors.max() < 0.01
