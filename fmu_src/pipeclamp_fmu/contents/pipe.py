"""What a pipe's FMU is made of, from a reduced pipe."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from importlib import resources

from pipeclamp_fmu.contents.content import Content
from pipeclamp_fmu.contents.pipe_dependencies import pipe_dependencies
from pipeclamp_fmu.contents.pipe_reference import pipe_reference
from pipeclamp_fmu.contents.reference import reference_files
from pipeclamp_fmu.describe.documentation import DocumentedSection, page, variables_section
from pipeclamp_fmu.describe.model_description import ModelText, Quantity, usual
from pipeclamp_fmu.slaves import pipe as pipe_slave
from pipeclamp_fmu.slaves.one_module import source_text, with_inlined
from pipeclamp_models.pipe.modes import ReducedPipe

STEPS_PER_CYCLE = 20
"""Of the default experiment, at the highest frequency that the pipe keeps."""

FARTHEST_M = 1.0
"""min and max of displacements, m: beyond, a value is a mistake of units."""


def pipe_module(pipe: ReducedPipe) -> str:
    """Give the slave's one module: the pipe's numbers, the stepping, the slave."""
    numbers = {
        "OMEGA": pipe.omega,
        "DAMPING": pipe.damping,
        "COUPLING_STIFFNESS": pipe.coupling_stiffness,
        "COUPLING_DAMPING": pipe.coupling_damping,
        "EXCITATION": pipe.excitation,
        "PARTICIPATION": pipe.excitation_participation,
        "CLAMP_NAMES": pipe.clamp_names,
        "CLAMP_SHAPES": pipe.clamp_shapes,
        "PROBE_NAMES": pipe.probe_names,
        "PROBE_SHAPES": pipe.probe_shapes,
    }
    stepping = {
        name: resources.files("pipeclamp_models").joinpath("pipe", f"{name}.py").read_text(encoding="utf-8")
        for name in ("step", "coupled_step")
    }
    return with_inlined(
        source_text("pipeclamp_fmu.slaves.pipe"),
        {
            **{f"pipeclamp_models.pipe.{name}": text for name, text in stepping.items()},
            "pipeclamp_fmu.slaves.plain": source_text("pipeclamp_fmu.slaves.plain"),
            "pipeclamp_fmu.slaves.stand_in_pipe": "\n".join(f"{name} = {value!r}" for name, value in numbers.items()),
        },
    )


def excitation_input(pipe: ReducedPipe) -> str:
    """Give the name of the input that shakes the pipe."""
    return "base.a" if pipe.excitation == "base" else "excitation.f"


def input_names(pipe: ReducedPipe) -> tuple[str, ...]:
    """Give the names of all inputs: what shakes the pipe, and the clamps' forces."""
    return (excitation_input(pipe), *(f"{name}.f" for name in pipe.clamp_names))


def quantities(pipe: ReducedPipe) -> Mapping[str, Quantity]:
    """Give what an importer should know of the pipe's variables."""
    lowest = min((omega for omega in pipe.omega if omega > 0), default=1.0)
    highest = 2 * math.pi * pipe.up_to_Hz
    s = 1e-3
    relative = ", relative to the base" if pipe.excitation == "base" else ""

    def displacement(text: str) -> Quantity:
        return Quantity(f"displacement{text}{relative}", "m", "mm", -FARTHEST_M, FARTHEST_M, s)

    def velocity(text: str) -> Quantity:
        limit = FARTHEST_M * highest
        return Quantity(f"velocity{text}{relative}", "m/s", "mm/s", -limit, limit, usual(lowest * s))

    def acceleration(text: str) -> Quantity:
        limit = FARTHEST_M * highest**2
        return Quantity(text, "m/s2", "", -limit, limit, usual(lowest**2 * s))

    def force(text: str) -> Quantity:
        limit = FARTHEST_M * pipe.mass * highest**2
        return Quantity(text, "N", "", -limit, limit, usual(pipe.mass * lowest**2 * s))

    def energy(text: str) -> Quantity:
        limit = pipe.mass * (FARTHEST_M * highest) ** 2
        return Quantity(text, "J", "", -limit, limit, usual(pipe.mass * (lowest * s) ** 2))

    described: dict[str, Quantity] = {
        excitation_input(pipe): acceleration("acceleration of the base")
        if pipe.excitation == "base"
        else force("force that shakes the pipe")
    }
    for name in pipe.clamp_names:
        described[f"{name}.f"] = force(f"force into clamp {name}; it acts on the pipe with the opposite sign")
        described[f"{name}.s"] = displacement(f" at clamp {name}")
        described[f"{name}.v"] = velocity(f" at clamp {name}")
    for name in pipe.probe_names:
        described[f"{name}.s"] = displacement(f" at probe {name}")
        described[f"{name}.v"] = velocity(f" at probe {name}")
        described[f"{name}.a"] = acceleration(f"absolute acceleration at probe {name}")
    described["energyPipe"] = energy("kinetic and strain energy of the pipe, with that of its axial force")
    described["energyDissipated"] = energy("what the pipe's own damping and a flow through its ends have taken")
    described["workExcitation"] = energy("work of the excitation on the pipe (of the inertia forces, for a base)")
    described["workClamps"] = energy("work that the pipe has done on the clamps")
    described["inputsAtStepEnd"] = Quantity(
        "inputs are those at the end of a step and linear over it (for sequential and iterated masters); else held"
    )
    return described


def pipe_text(pipe: ReducedPipe, version: str) -> ModelText:
    """Give what the description says of the whole."""
    return ModelText(
        title=f"Pipe {pipe.name}",
        description="Bending of a straight pipe in modes, with ports for clamps",
        version=version,
        step_size=usual(1 / (STEPS_PER_CYCLE * pipe.up_to_Hz)),
    )


def pipe_content(pipe: ReducedPipe, version: str) -> Content:
    """Give all that goes into the pipe's Python FMU."""
    described = quantities(pipe)
    text = pipe_text(pipe, version)
    reference = pipe_reference(pipe, text.step_size, input_names(pipe), described)
    return Content(
        kind="pipe",
        source=pipe_module(pipe),
        class_name=pipe_slave.PipeSlave.__name__,
        text=text,
        quantities=described,
        initially=pipe_dependencies(pipe, excitation_input(pipe)).initially,
        documentation=pipe_documentation(pipe, described, "Standard library of Python only."),
        further=reference_files(reference, model_exchange=False),
    )


def pipe_documentation(pipe: ReducedPipe, described: Mapping[str, Quantity], needs: str) -> str:
    """Give the page that travels inside the FMU; `needs` says what this kind of FMU runs on."""
    text = pipe_text(pipe, "")
    introduction = (text.description + ".", *pipe.summary().splitlines())
    return page(text.title, introduction, _sections(pipe, described, needs))


def _sections(pipe: ReducedPipe, described: Mapping[str, Quantity], needs: str) -> Sequence[DocumentedSection]:
    modes = enumerate(zip(pipe.omega, pipe.zeta, strict=True), start=1)
    return [
        DocumentedSection(
            "Equations",
            (
                "Per mode, with u the base's acceleration or the exciting force and f the force into each clamp. "
                "Steps are exact for inputs that are constant or linear over a step.",
            ),
            (
                "q'' + 2 zeta omega q' + omega^2 q = participation u - sum over clamps of shape f",
                "s = sum over modes of shape q",
            ),
        ),
        *([_coupling_section(pipe)] if pipe.coupling_stiffness else []),
        DocumentedSection(
            "Modes",
            ("Those after the kept ones stand for the static flexibility of the modes left out.",),
            (),
            ("mode", "frequency, Hz", "damping ratio", ""),
            [
                (str(n), f"{omega / (2 * math.pi):.6g}", f"{zeta:.4g}", "kept" if n <= pipe.kept else "residual")
                for n, (omega, zeta) in modes
            ],
        ),
        variables_section(described),
        DocumentedSection(
            "Use",
            (
                "The pipe starts at rest. Without inputsAtStepEnd inputs are held over the step, as masters that step "
                "all models in parallel expect.",
                "workExcitation - workClamps = energyPipe + energyDissipated at every communication point.",
                "A step with a NaN or infinite input, or not above 0, is discarded with a logged error, the state "
                f"untouched. States are saved, restored and serialised exactly. {needs}",
            ),
        ),
    ]


def _coupling_section(pipe: ReducedPipe) -> DocumentedSection:
    return DocumentedSection(
        "Axial force and flow",
        (
            "They couple the modes of the pipe at rest: full matrices K and C are added to omega^2 and 2 zeta omega, "
            "and steps are exact for the coupled equations. Without clamps the pipe then has these natural "
            "frequencies, in Hz: " + ", ".join(f"{frequency:.6g}" for frequency in pipe.frequencies) + ".",
        ),
        ("q'' + (2 zeta omega + C) q' + (omega^2 + K) q = participation u - sum over clamps of shape f",),
    )
