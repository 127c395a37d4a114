"""What holds for every straight pipe, wherever its supports, masses and clamps are."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeclamp_models.pipe.beam import Attachment, Beam, assemble, mesh, modes
from pipeclamp_models.pipe.description import PipeDescription
from pipeclamp_models.pipe.modes import ReducedPipe, reduce

LENGTH = 6.0
positions = st.floats(0.05, LENGTH - 0.05).map(lambda x: round(x, 2))
ends = st.sampled_from(["free", "pinned", "clamped", "guided"])


def frequencies(attachments: tuple[Attachment, ...]) -> np.ndarray:
    beam = Beam(LENGTH, 5e4, 7.0)
    nodes = mesh(LENGTH, tuple(sorted({entry.position for entry in attachments})), (), 0.3)
    return modes(beam, assemble(beam, nodes, attachments))[0][:6]


@settings(max_examples=40, deadline=None)
@given(support=positions, spring=positions, stiffness=st.floats(0.0, 1e8), mass=st.floats(0.0, 500.0))
def test_a_spring_never_lowers_a_frequency_and_a_mass_never_raises_one(
    support: float, spring: float, stiffness: float, mass: float
) -> None:
    base = (Attachment(0.0, float("inf"), 0.0), Attachment(support, float("inf")), Attachment(spring))
    plain = frequencies(base)
    stiffer = frequencies((*base, Attachment(spring, stiffness=stiffness)))
    heavier = frequencies((*base, Attachment(spring, mass=mass)))
    assert np.all(stiffer >= plain * (1 - 1e-6))
    assert np.all(heavier <= plain * (1 + 1e-6))


def described(left: str, right: str, clamp: float, probe: float) -> PipeDescription:
    return PipeDescription.model_validate(
        {
            "name": "any",
            "pipe": {"outer_diameter_mm": 60.3, "wall_mm": 3.91, "length_m": LENGTH, "material": "316L"},
            "ends": {"left": left, "right": right},
            "clamps": [{"name": "c", "position_m": clamp}],
            "probes": [{"name": "p", "position_m": probe}],
            "damping": {"ratio": 0.01},
            "modes": {"up_to_Hz": 150.0},
        }
    )


def transfer(pipe: ReducedPipe, frequency: float) -> complex:
    """Give the displacement of the probe per newton at the clamp, m/N, at a frequency in Hz."""
    s = 2j * np.pi * frequency
    modal = s**2 + s * np.array(pipe.damping) + np.array(pipe.omega) ** 2
    return complex(np.sum(np.array(pipe.probe_shapes[0]) * np.array(pipe.clamp_shapes[0]) / modal))


@settings(max_examples=25, deadline=None)
@given(left=ends, right=ends, clamp=positions, probe=positions)
def test_a_reduced_pipe_is_statically_exact_and_reciprocal(left: str, right: str, clamp: float, probe: float) -> None:
    there: ReducedPipe = reduce(described(left, right, clamp, probe))
    back: ReducedPipe = reduce(described(left, right, probe, clamp))
    assert there.errors.static < 1e-6
    assert there.errors.response < 0.2
    # The displacement at p under a load at c is that at c under a load at p (Maxwell, Betti), at any frequency below.
    assert abs(transfer(there, 5.0) - transfer(back, 5.0)) < 1e-3 * abs(transfer(there, 5.0)) + 1e-9
