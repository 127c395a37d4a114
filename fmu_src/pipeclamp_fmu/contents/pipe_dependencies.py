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
    modes = range(len(pipe.omega))
    inputs = {excitation: pipe.excitation_participation} | {
        f"{name}.f": shape for name, shape in zip(pipe.clamp_names, pipe.clamp_shapes, strict=True)
    }
    stiffness, damping = pipe.stiffness_matrix.tolist(), pipe.damping_matrix.tolist()
    rates = [
        (
            *(name for name, shape in inputs.items() if shape[mode]),
            *(displacement(other) for other in modes if stiffness[mode][other]),
            *(velocity(other) for other in modes if damping[mode][other]),
        )
        for mode in modes
    ]
    always: dict[str, Iterable[str]] = {}
    for name, shape in _seen(pipe).items():
        always[f"{name}.s"] = [displacement(mode) for mode in modes if shape[mode]]
        always[f"{name}.v"] = [velocity(mode) for mode in modes if shape[mode]]
    for name, shape in zip(pipe.probe_names, pipe.probe_shapes, strict=True):
        carried = [excitation] if pipe.excitation == "base" else []
        always[f"{name}.a"] = [*carried, *(entry for mode in modes if shape[mode] for entry in rates[mode])]
    motion = [
        *(displacement(mode) for mode in modes if any(stiffness[mode])),
        *(velocity(mode) for mode in modes),
    ]
    always |= {
        "energyPipe": motion,
        "energyDissipated": [*motion, *WORKS],
        "workExcitation": WORKS[:1],
        "workClamps": WORKS[1:],
    }
    moved = [
        [velocity(mode) for mode in modes if any(shape[mode] for shape in shapes)]
        for shapes in ([pipe.excitation_participation], pipe.clamp_shapes)
    ]
    always |= {f"der({displacement(mode)})": [velocity(mode)] for mode in modes}
    always |= {f"der({velocity(mode)})": rates[mode] for mode in modes}
    always |= {
        f"der({work})": [*acting, *speeds]
        for work, acting, speeds in zip(WORKS, ([excitation], list(inputs)[1:]), moved, strict=True)
    }
    # The pipe starts at rest: only its accelerations aren't zero.
    by_inputs = {name: [entry for entry in of if entry in inputs] for name, of in always.items()}
    initially = {name: of for name, of in by_inputs.items() if name.endswith(".a") or name.startswith("der(mode.p")}
    return Dependencies(_once(always), _once(initially))


def _seen(pipe: ReducedPipe) -> dict[str, Sequence[float]]:
    """Give the shapes of clamps and probes by name."""
    names, shapes = (*pipe.clamp_names, *pipe.probe_names), (*pipe.clamp_shapes, *pipe.probe_shapes)
    return dict(zip(names, shapes, strict=True))


def _once(dependencies: Mapping[str, Iterable[str]]) -> dict[str, tuple[str, ...]]:
    return {name: tuple(dict.fromkeys(of)) for name, of in dependencies.items()}
