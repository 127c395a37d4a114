"""What a pipe's native FMU is made of: the same variables as the Python FMU's, its modes as C."""

from __future__ import annotations

from collections.abc import Sequence

from pipeclamp_fmu.contents.pipe import excitation_input, input_names, pipe_documentation, pipe_text, quantities
from pipeclamp_fmu.contents.pipe_dependencies import WORKS, displacement, pipe_dependencies, velocity
from pipeclamp_fmu.contents.pipe_reference import pipe_reference
from pipeclamp_fmu.contents.reference import reference_files
from pipeclamp_fmu.describe.model_description import Quantity
from pipeclamp_fmu.describe.variables import Variable, Variables
from pipeclamp_fmu.native.description import FLANGE, Terminal
from pipeclamp_fmu.native.packing import NativeContent
from pipeclamp_fmu.native.sources import NativeModel
from pipeclamp_models.pipe.modes import ReducedPipe

Nested = Sequence["float | Nested"]

NEEDS = (
    "In model exchange the modes and the two works are continuous states; inputs are those of the present time. "
    "Directional derivatives are exact: of outputs and of the states' derivatives, by inputs and states; in "
    "co-simulation of the last step's outputs by its inputs. "
    "Standard C library only; the sources are inside."
)


def native_pipe(pipe: ReducedPipe, version: str) -> NativeContent:
    """Give all that goes into the pipe's native FMU."""
    described = dict(quantities(pipe))
    flag = described.pop("inputsAtStepEnd")
    inputs = input_names(pipe)
    states = _states(pipe)
    variables = Variables(
        inputs=tuple(Variable(name, described[name], 0.0) for name in inputs),
        parameters=(),
        outputs=tuple(Variable(name, described[name]) for name in _outputs(pipe)),
        locals=(*states, *(Variable(f"der({entry.name})", _rate(entry.quantity)) for entry in states)),
        fixed=(),
        boolean_parameters=(Variable("inputsAtStepEnd", flag, False),),
        boolean_locals=(),
        signals=len(inputs),
        states=len(states),
    )
    text = pipe_text(pipe, version)
    reference = pipe_reference(pipe, text.step_size, inputs, described)
    return NativeContent(
        kind="pipe",
        text=text,
        model=NativeModel(
            pipe.name,
            ("pipe.c", "pipe.h", "no_warnings.c"),
            {"modes.h": _modes(pipe)},
            variables,
            (),
        ),
        terminals=[_port(name) for name in pipe.clamp_names],
        dependencies=pipe_dependencies(pipe, excitation_input(pipe)),
        documentation=pipe_documentation(pipe, quantities(pipe), NEEDS),
        icon=b"",
        further=reference_files(reference, model_exchange=True),
    )


def _states(pipe: ReducedPipe) -> tuple[Variable, ...]:
    """Give the continuous states in the order in which pipe.c has them: modes of unit mass, then works."""
    modes = range(len(pipe.omega))
    slowest = min((omega for omega in pipe.omega if omega > 0), default=1.0)
    q, p = 1e-3, 1e-3 * slowest
    return (
        *(Variable(displacement(n), Quantity(f"displacement of mode {n + 1}, sqrt(kg) m", nominal=q)) for n in modes),
        *(Variable(velocity(n), Quantity(f"velocity of mode {n + 1}, sqrt(kg) m/s", nominal=p)) for n in modes),
        *(
            Variable(name, Quantity(meaning, "J", nominal=p * p))
            for name, meaning in zip(WORKS, ("work of the excitation", "work done on the clamps"), strict=True)
        ),
    )


def _rate(quantity: Quantity) -> Quantity:
    return Quantity(f"change of the {quantity.description} per second")


def _outputs(pipe: ReducedPipe) -> tuple[str, ...]:
    """Give the outputs in the order in which pipe.c writes them."""
    return (
        *(f"{name}.{letter}" for letter in "sv" for name in pipe.clamp_names),
        *(f"{name}.{letter}" for letter in "sva" for name in pipe.probe_names),
        "energyPipe",
        "energyDissipated",
        "workExcitation",
        "workClamps",
    )


def _port(name: str) -> Terminal:
    """Give a clamp's port: the force into the clamp flows out of the pipe."""
    return Terminal(
        name, FLANGE, {"s": (f"{name}.s", "signal"), "v": (f"{name}.v", "signal"), "f": (f"{name}.f", "inflow")}
    )


def _modes(pipe: ReducedPipe) -> str:
    """Give `modes.h`: the pipe's numbers. Coupled modes are one block of the matrices, others a block each."""
    count = len(pipe.omega)
    own = [[omega**2, damping] for omega, damping in zip(pipe.omega, pipe.damping, strict=True)]
    stiffness: Nested
    damping: Nested
    if pipe.coupling_stiffness:
        stiffness = [_with_diagonal(pipe.coupling_stiffness, [entry[0] for entry in own])]
        damping = [_with_diagonal(pipe.coupling_damping, [entry[1] for entry in own])]
    else:
        stiffness, damping = ([[[entry[index]]] for entry in own] for index in (0, 1))
    block = count if pipe.coupling_stiffness else 1
    no_shape = [[0.0] * count]
    matrix = "[BLOCKS][BLOCK][BLOCK]"
    return "\n".join(
        [
            "/* Generated: the pipe in modes of unit mass, SI units. */",
            f"enum {{ MODES = {count}, CLAMPS = {len(pipe.clamp_names)}, PROBES = {len(pipe.probe_names)},"
            f" BLOCK = {block}, BLOCKS = {count // block} }};",
            "/* Share of the base's acceleration in the absolute acceleration of a probe. */",
            f"static const double CARRIED = {float(pipe.excitation == 'base')!r};",
            _array("PARTICIPATION", "[MODES]", pipe.excitation_participation),
            _array("CLAMP_SHAPES", "[ROOM(CLAMPS)][MODES]", pipe.clamp_shapes or no_shape),
            _array("PROBE_SHAPES", "[ROOM(PROBES)][MODES]", pipe.probe_shapes or no_shape),
            _array("STIFFNESS", matrix, stiffness),
            _array("DAMPING", matrix, damping),
            "",
        ]
    )


def _with_diagonal(rows: Sequence[Sequence[float]], diagonal: Sequence[float]) -> Nested:
    return [
        [entry + diagonal[row] * (row == column) for column, entry in enumerate(entries)]
        for row, entries in enumerate(rows)
    ]


def _array(name: str, shape: str, values: Nested) -> str:
    return f"static const double {name}{shape} = {_braced(values)};"


def _braced(values: float | Nested) -> str:
    if isinstance(values, (int, float)):
        return repr(float(values))
    return "{" + ", ".join(_braced(entry) for entry in values) + "}"
