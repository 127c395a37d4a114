"""What a pipe's outputs and its states' derivatives depend on: where its matrices have entries."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from pipeclamp_fmu.describe.variables import Dependencies
from pipeclamp_models.pipe.modes import ReducedPipe

WORKS = ("work.excitation", "work.clamps")
"""States beside the modes: work of the excitation on the pipe, and of the pipe on the clamps."""


def displacement(mode: int) -> str:
    """Give the name of a mode's displacement, modes counted from 0."""
    return f"mode.q[{mode + 1}]"


def velocity(mode: int) -> str:
    """Give the name of a mode's velocity."""
    return f"mode.p[{mode + 1}]"


def pipe_dependencies(pipe: ReducedPipe, excitation: str) -> Dependencies:
    """Give what the pipe's outputs and derivatives depend on; `excitation` is the input that shakes it."""
    shapes = {excitation: pipe.excitation_participation} | {
        f"{name}.f": shape for name, shape in zip(pipe.clamp_names, pipe.clamp_shapes, strict=True)
    }
    accelerations = _accelerations(pipe, shapes)
    always = {
        **_motions(pipe),
        **_probe_accelerations(pipe, excitation, accelerations),
        **_energies(pipe),
        **_derivatives(pipe, excitation, accelerations),
    }
    # The pipe starts at rest: only its accelerations aren't zero.
    by_inputs = {name: [entry for entry in of if entry in shapes] for name, of in always.items()}
    initially = {name: of for name, of in by_inputs.items() if name.endswith(".a") or name.startswith("der(mode.p")}
    return Dependencies(_once(always), _once(initially))


def _accelerations(pipe: ReducedPipe, shapes: Mapping[str, Sequence[float]]) -> list[list[str]]:
    """Give what each mode's acceleration depends on: inputs by their shapes, and modes by the matrices."""
    modes = range(len(pipe.omega))
    stiffness, damping = pipe.stiffness_matrix.tolist(), pipe.damping_matrix.tolist()
    return [
        [
            *(name for name, shape in shapes.items() if shape[mode]),
            *(displacement(other) for other in modes if stiffness[mode][other]),
            *(velocity(other) for other in modes if damping[mode][other]),
        ]
        for mode in modes
    ]


def _motions(pipe: ReducedPipe) -> dict[str, Iterable[str]]:
    """Give what displacement and velocity of clamps and probes depend on."""
    found: dict[str, Iterable[str]] = {}
    for name, shape in _seen(pipe).items():
        moving = [mode for mode, share in enumerate(shape) if share]
        found[f"{name}.s"] = [displacement(mode) for mode in moving]
        found[f"{name}.v"] = [velocity(mode) for mode in moving]
    return found


def _probe_accelerations(
    pipe: ReducedPipe, excitation: str, accelerations: Sequence[Iterable[str]]
) -> dict[str, Iterable[str]]:
    """Give what the acceleration of probes depends on; a shaken base carries them along."""
    carried = [excitation] if pipe.excitation == "base" else []
    return {
        f"{name}.a": [*carried, *(entry for mode, share in enumerate(shape) if share for entry in accelerations[mode])]
        for name, shape in zip(pipe.probe_names, pipe.probe_shapes, strict=True)
    }


def _energies(pipe: ReducedPipe) -> dict[str, Iterable[str]]:
    """Give what the pipe's energy, what it dissipates, and the works depend on."""
    stiffness = pipe.stiffness_matrix.tolist()
    modes = range(len(pipe.omega))
    motion = [*(displacement(mode) for mode in modes if any(stiffness[mode])), *map(velocity, modes)]
    return {
        "energyPipe": motion,
        "energyDissipated": [*motion, *WORKS],
        "workExcitation": WORKS[:1],
        "workClamps": WORKS[1:],
    }


def _derivatives(
    pipe: ReducedPipe, excitation: str, accelerations: Sequence[Iterable[str]]
) -> dict[str, Iterable[str]]:
    """Give what derivatives depend on: those of the works on their loads, and on the speeds that these act on."""
    modes = range(len(pipe.omega))
    loads = ([excitation], [f"{name}.f" for name in pipe.clamp_names])
    acted_on = ([pipe.excitation_participation], pipe.clamp_shapes)
    found: dict[str, Iterable[str]] = {f"der({displacement(mode)})": [velocity(mode)] for mode in modes}
    found |= {f"der({velocity(mode)})": accelerations[mode] for mode in modes}
    for work, acting, shapes in zip(WORKS, loads, acted_on, strict=True):
        speeds = [velocity(mode) for mode in modes if any(shape[mode] for shape in shapes)]
        found[f"der({work})"] = [*acting, *speeds]
    return found


def _seen(pipe: ReducedPipe) -> dict[str, Sequence[float]]:
    """Give the shapes of clamps and probes by name."""
    names, shapes = (*pipe.clamp_names, *pipe.probe_names), (*pipe.clamp_shapes, *pipe.probe_shapes)
    return dict(zip(names, shapes, strict=True))


def _once(dependencies: Mapping[str, Iterable[str]]) -> dict[str, tuple[str, ...]]:
    return {name: tuple(dict.fromkeys(of)) for name, of in dependencies.items()}
