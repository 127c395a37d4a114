"""Peaks of pipes with shear, on clamps from soft to rigid, against Timoshenko's equations without modes or elements.

Between places that matter the state (w, rotation, moment, shear force) obeys four linear equations of the first order,
which a matrix exponential carries along (Pestel & Leckie, Matrix Methods in Elastomechanics, 1963). Damping
alpha M + beta K turns stiffnesses by 1 + i omega beta and masses by 1 - i alpha/omega.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from scipy.linalg import expm

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.pipe.beam import Beam
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_models.pipe.section import beam_of

PIECE = 1 / 40
"""Of the pipe's length: carried over more of it, growing waves would cost digits."""
PIPES = {
    "thick": ((219.1, 25.0, 2.0, 3000.0), (0.7, 1.3, 1.6)),
    "thick, two modes": ((168.3, 20.0, 1.2, 800.0), (0.5, 0.8, 0.9)),
    "thin": ((60.3, 2.9, 6.0, 150.0), (1.9, 3.7, 4.4)),
}
"""Outer diameter and wall in mm, length in m, end of the band in Hz; places of clamp, probe and force in m."""
ZETA = 0.003
"""Damping ratio at the band's end; it falls below it."""


def described(size, places, beta):
    outer, wall, length, up_to = size
    clamp, probe, force = places
    return parse_pipe(f"""
name = "pinned"
ends = {{ left = "pinned", right = "pinned" }}
clamps = [{{ name = "clamp", position_m = {clamp} }}]
probes = [{{ name = "probe", position_m = {probe} }}]
excitation = {{ kind = "force", position_m = {force} }}
damping = {{ rayleigh_alpha_1_s = 0.0, rayleigh_beta_s = {beta!r} }}
modes = {{ up_to_Hz = {up_to} }}
[pipe]
outer_diameter_mm = {outer}
wall_mm = {wall}
length_m = {length}
material = "316L"
fluid = "water"
theory = "timoshenko"
""")


def piece_stiffness(beam: Beam, omega: float, beta: float, length: float) -> np.ndarray:
    """Give forces and moments over displacements and rotations of a piece's ends, (4, 4)."""
    bending, shear = (
        stiffness * (1 + 1j * omega * beta) for stiffness in (beam.bending_stiffness, beam.shear_stiffness)
    )
    rates = np.zeros((4, 4), dtype=complex)
    rates[0, 1], rates[0, 3], rates[1, 2] = 1.0, 1 / shear, 1 / bending
    rates[2, 1], rates[2, 3], rates[3, 0] = -beam.rotary_inertia * omega**2, -1.0, -beam.mass_per_length * omega**2
    sizes = np.array([1.0, 1 / length, beam.bending_stiffness / length**2, beam.bending_stiffness / length**3])
    carried = expm(rates * length * sizes / sizes[:, None]) * sizes[:, None] / sizes
    moved, by_load = carried[:2, :2], carried[:2, 2:]
    # rows: moment and shear force at the ends, to be turned into the force and the moment that act on each
    at_start = np.linalg.solve(by_load, np.hstack([-moved, np.eye(2)]))
    at_end = carried[2:, :2] @ np.eye(2, 4) + carried[2:, 2:] @ at_start
    return np.vstack([-at_start[::-1], at_end[::-1]])


def probe_by_waves(beam: Beam, places, clamp: float, beta: float, frequencies: Array) -> np.ndarray:
    """Give the displacement of the probe per newton at the force, m/N, with a spring at the clamp (N/m)."""
    stops = sorted({0.0, *places, beam.length})
    counts = [int(np.ceil((b - a) / (PIECE * beam.length))) for a, b in pairwise(stops)]
    nodes = [
        a + (b - a) * n / count for (a, b), count in zip(pairwise(stops), counts, strict=True) for n in range(count)
    ]
    nodes.append(beam.length)
    at_clamp, at_probe, at_force = (2 * int(np.argmin(np.abs(np.array(nodes) - place))) for place in places)
    free = [freedom for freedom in range(2 * len(nodes)) if freedom not in (0, 2 * len(nodes) - 2)]
    found = []
    for omega in frequencies:
        whole = np.zeros((2 * len(nodes), 2 * len(nodes)), dtype=complex)
        pieces = {length: piece_stiffness(beam, omega, beta, length) for length in set(np.round(np.diff(nodes), 9))}
        for index, length in enumerate(np.round(np.diff(nodes), 9)):
            whole[2 * index : 2 * index + 4, 2 * index : 2 * index + 4] += pieces[length]
        whole[at_clamp, at_clamp] += clamp
        load = np.zeros(2 * len(nodes))
        load[at_force] = 1.0
        moved = np.zeros(2 * len(nodes), dtype=complex)
        moved[free] = np.linalg.solve(whole[np.ix_(free, free)], load[free])
        found.append(moved[at_probe])
    return np.array(found)


@pytest.mark.parametrize("name", PIPES)
def test_peaks_err_by_no_more_than_what_is_stated(name: str) -> None:
    size, places = PIPES[name]
    end = 2 * pi * size[3]
    beta = 2 * ZETA / end
    description = described(size, places, beta)
    pipe, beam = reduce(description), beam_of(description)
    assert pipe.errors.clamped <= 0.01
    at_clamp, at_probe = np.array(pipe.clamp_shapes[0]), np.array(pipe.probe_shapes[0])
    soft = max(pipe.errors.clamped_at) / np.array([1e4, 100.0, 10.0, 1.0])
    errors = []
    for clamp in np.unique([*soft, *(soft * 10)]):
        stiffness = np.diag(np.square(pipe.omega)) + clamp * np.outer(at_clamp, at_clamp)
        peaks = np.sqrt(np.linalg.eigvalsh(stiffness))
        peaks = peaks[peaks < end]
        exact = probe_by_waves(beam, places, clamp, beta, peaks)
        damped = np.diag(pipe.damping)
        dynamic = [stiffness - w**2 * np.eye(len(stiffness)) + 1j * w * damped for w in peaks]
        found = np.array([at_probe @ np.linalg.solve(one, pipe.excitation_participation) for one in dynamic])
        high = np.abs(exact) > np.exp(np.log(np.abs(exact)).mean()) / 2  # those that the probe stands still at aside
        errors.append(np.max(np.abs(found - exact)[high] / np.abs(exact)[high]))
    assert max(errors) <= 1.1 * pipe.errors.clamped, errors
