"""What a clamp's FMU is made of, from a law's generated source."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from pipeclamp_fmu.contents.behind import behind_section, related
from pipeclamp_fmu.contents.clamp_dependencies import clamp_dependencies
from pipeclamp_fmu.contents.clamp_model import TEMPERATURE_BOUNDS, ClampModel, FurtherCondition, middle
from pipeclamp_fmu.contents.content import Content
from pipeclamp_fmu.contents.continuous_memory import parts_of_step
from pipeclamp_fmu.contents.passivity import Interval
from pipeclamp_fmu.contents.reference import Reference, reference_files
from pipeclamp_fmu.contents.steady_loop import SAMPLES_PER_CYCLE, steady_loop
from pipeclamp_fmu.describe.documentation import DocumentedSection, page, variables_section
from pipeclamp_fmu.describe.history import history_section
from pipeclamp_fmu.describe.icon import loop_icon
from pipeclamp_fmu.describe.model_description import ModelText, Quantity, usual
from pipeclamp_fmu.describe.variables import Variable, Variables, numbers_of
from pipeclamp_fmu.slaves import clamp as clamp_slave
from pipeclamp_fmu.slaves import own_motion
from pipeclamp_fmu.slaves.one_module import source_text, with_inlined
from pipeclamp_fmu.slaves.values_file import values_text
from pipeclamp_models.steps import tracker

RANGE_MARGIN = 10.0
"""min and max of variables lie this factor beyond the law's range: further out a value is a mistake of units."""

STEPS_PER_CYCLE = 200
"""Of the default experiment, at the highest frequency in range."""


def clamp_module(model: ClampModel) -> str:
    """Give the slave's one module: equations and slave; no value of the law is in it."""
    further = tuple((entry.name, entry.law_unit, entry.scale, entry.positive) for entry in model.further)
    law = "\n".join(
        [
            f"FURTHER = {further!r}",
            f"COUNTED = {model.counted}",
            f"PARTS = {parts_of_step(model)}",
            f"COEFFICIENTS = {tuple(entry.name for entry in model.coefficients)!r}",
            "",
            model.source,
        ]
    )
    slaves = (f"pipeclamp_fmu.slaves.{name}" for name in ("own_motion", "plain", "values_file"))
    steps = (f"pipeclamp_models.steps.{name}" for name in ("tracker", "within_step"))
    parts = {module: source_text(module) for module in (*slaves, *steps)}
    return with_inlined(source_text("pipeclamp_fmu.slaves.clamp"), {**parts, "pipeclamp_fmu.slaves.stand_in_law": law})


def quantities(model: ClampModel) -> Mapping[str, Quantity]:
    """Give what an importer should know of the clamp's variables."""
    law = model.law
    A, f, T = middle(model.range_A), middle(model.range_f), model.temperature
    start = tuple(value for _, value in law.states)
    middles = tuple(entry.scale * entry.start for entry in model.further)
    force = usual(law.step(law.coefficients(A, f, T, *middles), start, 0.0, A, 0.0, 1 / (4 * f))[0])
    farthest = RANGE_MARGIN * model.range_A[1] / 1000
    fastest = 2 * math.pi * RANGE_MARGIN * model.range_f[1] * farthest
    s, about = usual(A / 1000), model.about / 1000
    v = usual(2 * math.pi * f * A / 1000)

    def amplitude(text: str) -> Quantity:
        return Quantity(text, "m", "mm", model.range_A[0] / 1000 / RANGE_MARGIN, farthest, s)

    def frequency(text: str) -> Quantity:
        return Quantity(text, "Hz", "", model.range_f[0] / RANGE_MARGIN, RANGE_MARGIN * model.range_f[1], usual(f))

    def temperature(text: str) -> Quantity:
        return Quantity(text, "K", "degC", *TEMPERATURE_BOUNDS, usual(T))

    def in_range(interval: Interval, unit: str) -> str:
        return f"(law's range {interval[0]:g} to {interval[1]:g} {unit})"

    range_A, range_f = in_range(model.range_A, "mm"), in_range(model.range_f, "Hz")
    range_T = in_range(model.range_T, "K") if model.range_T else "(its law was identified without)"
    return {
        "flange.s": Quantity(
            "displacement of the clamp at the end of the step",
            "m",
            "mm",
            min(0.0, about) - farthest,
            max(0.0, about) + farthest,
            usual(max(A / 1000, abs(about))),
        ),
        "flange.v": Quantity("its velocity at the end of the step", "m/s", "mm/s", -fastest, fastest, v),
        "T_in": temperature(f"temperature from outside, used where useTemperatureInput is true {range_T}"),
        "A": amplitude(f"amplitude of the motion {range_A}"),
        "f": frequency(f"frequency of the motion {range_f}"),
        "T": temperature(f"temperature of the clamp {range_T}"),
        **{entry.name: _further(entry) for entry in model.further},
        "flange.f": Quantity("force into the clamp; a spring gives +c s", "N", "", -1e3 * force, 1e3 * force, force),
        "A_used": amplitude("amplitude that the law is evaluated with"),
        "f_used": frequency("frequency that the law is evaluated with"),
        "T_used": temperature("temperature that the law is evaluated with"),
        "energyDissipated": Quantity(
            "work of flange.f on the clamp less what the clamp stores", "J", "", -1e6, 1e6, usual(force * s)
        ),
        "forceDeviation": Quantity(
            "rms difference of the force for the A and f that were told from that for A and f of the motion, as a "
            "share of the latter's rms; of the last cycle",
            "1",
            "",
            0.0,
            1e6,
            own_motion.LIMIT,
        ),
        "useTemperatureInput": Quantity("take T_in in place of the parameter T"),
        "track": Quantity("estimate amplitude and frequency from the motion, starting from A and f"),
        "inRange": Quantity(
            "A, f, T of the motion (followed: but for 1 %) and the displacement lie inside the law's range"
        ),
    }


def _further(entry: FurtherCondition) -> Quantity:
    """Give what an importer should know of a further condition."""
    low, high = (end / entry.scale for end in entry.interval)
    room = (RANGE_MARGIN - 1) * max(abs(low), abs(high), high - low)
    lowest = low / RANGE_MARGIN if entry.positive else 0.0 if entry.counted else low - room
    text = f"{entry.meaning} (law's range {entry.interval[0]:g} to {entry.interval[1]:g} {entry.law_unit})"
    return Quantity(
        text.replace(" )", ")"), entry.unit, entry.display_unit, lowest, high + room, usual(entry.start or high)
    )


def clamp_text(model: ClampModel, version: str) -> ModelText:
    """Give what the description says of the whole."""
    return ModelText(
        title=f"Pipe clamp, law {model.name}",
        description="Hysteretic force of a pipe clamp from displacement, velocity and temperature",
        version=version,
        step_size=usual(1 / (STEPS_PER_CYCLE * model.range_f[1])),
    )


def clamp_variables(model: ClampModel, described: Mapping[str, Quantity]) -> Variables:
    """Give the clamp's variables, but for those that show its memory."""
    start = model.start
    options: dict[str, float | bool | None] = {"A": start.A, "f": start.f, "T": start.T, "track": start.track or None}
    asked = {name: value for name, value in options.items() if value is not None}
    temperature = model.temperature if start.T is None else start.T
    starts: dict[str, float | bool] = {
        "flange.s": 0.0,
        "flange.v": 0.0,
        "T_in": temperature,
        "A": middle(model.range_A) / clamp_slave.MM,
        "f": middle(model.range_f),
        "T": temperature,
        **{entry.name: entry.start for entry in model.further},
        "useTemperatureInput": start.connected_temperature,
        "track": False,
        **asked,
    }

    def known(names: Iterable[str]) -> tuple[Variable, ...]:
        return tuple(Variable(name, described[name], starts.get(name), name in asked) for name in names)

    coefficients = [
        Variable(
            f"{clamp_slave.LAW}{entry.name}",
            Quantity(f"coefficient of the law: {entry.meaning}", entry.unit.replace("-", "")),
            entry.value,
        )
        for entry in model.coefficients
    ]
    return Variables(
        inputs=known(clamp_slave.INPUTS),
        parameters=known(model.condition_names),
        outputs=known(clamp_slave.OUTPUTS),
        locals=(),
        fixed=tuple(coefficients),
        boolean_parameters=known(clamp_slave.BOOLEAN_PARAMETERS),
        boolean_locals=known(clamp_slave.BOOLEAN_LOCALS),
        signals=clamp_slave.T_IN,
        unconnected=int(not start.connected_temperature),
    )


def clamp_extras(model: ClampModel, variables: Variables, model_exchange: bool) -> tuple[bytes, dict[str, bytes]]:
    """Give the clamp's icon and the reference results that travel inside its FMU, for model exchange too or not."""
    loop = steady_loop(clamp_module(model), values_text("", model.name, numbers_of(variables, model.ranges)))
    reference = Reference(
        name="loop",
        description="two cycles from rest in the middle of the law's range, under the default conditions",
        step=loop.step,
        stimuli={"flange.s": loop.s, "flange.v": loop.v},
        results={"flange.f": loop.force, "energyDissipated": loop.dissipated},
        at_once=True,
    )
    icon = loop_icon(loop.s[-SAMPLES_PER_CYCLE:], loop.force[-SAMPLES_PER_CYCLE:])
    return icon, reference_files(reference, model_exchange, related(model.behind) if model.behind else ())


def clamp_content(model: ClampModel, version: str, *, extras: bool = True) -> Content:
    """Give all that goes into the clamp's Python FMU; what `clamp_extras` gives, if asked."""
    described = quantities(model)
    variables = clamp_variables(model, described)
    files = {}
    if extras:
        icon, references = clamp_extras(model, variables, model_exchange=False)
        files = {"model.png": icon, **references}
    further = [entry.name for entry in model.further]
    return Content(
        kind="clamp",
        source=clamp_module(model),
        class_name=clamp_slave.ClampSlave.__name__,
        text=clamp_text(model, version),
        quantities={variable.name: variable.quantity for variable in variables.all},
        initially=clamp_dependencies(model.source, variables, further).initially,
        documentation=clamp_documentation(model, described, PYTHON_USE),
        further=files,
        name=model.name,
        numbers=numbers_of(variables, model.ranges),
        tunable=tuple(entry.name for entry in variables.inputs if entry not in variables.connected),
    )


def clamp_documentation(model: ClampModel, described: Mapping[str, Quantity], use: Sequence[str]) -> str:
    """Give the page that travels inside the FMU.

    Args:
        model: the law.
        described: what is said of each variable.
        use: how to use this kind of FMU.
    """
    text = clamp_text(model, "")
    return page(text.title, (text.description + ".", *model.notes), _sections(model, described, use))


def _sections(model: ClampModel, described: Mapping[str, Quantity], use: Sequence[str]) -> list[DocumentedSection]:
    return [
        DocumentedSection(
            "Equations",
            ("y in mm, v in mm/s, force F in N; A, f, T are amplitude (mm), frequency (Hz), temperature (K).",),
            model.equations,
        ),
        *([history_section(model.history, model.fit)] if model.history or model.fit else ()),
        *((behind_section(model.behind),) if model.behind else ()),
        DocumentedSection(
            "Parameters", (), (), ("symbol", "value", "standard error", "unit", "meaning"), model.parameters
        ),
        DocumentedSection(
            "Range",
            (
                "Where the law's data lie. Outside, the clamp warns once and inRange is false; so it is for "
                "displacements beyond the largest amplitude.",
            ),
            (),
            ("quantity", "from", "to", "unit"),
            [
                (name, f"{entry.minimum:g}", f"{entry.maximum:g}", entry.unit)
                for name, entry in zip(model.condition_names, model.ranges, strict=True)
                if name != "T" or model.range_T
            ],
        ),
        variables_section(described),
        DocumentedSection(
            "Use",
            (
                *use,
                "With track, amplitude and frequency come from averages of y, y^2 and v^2 over the last few cycles "
                f"(two first-order filters in a row, time constant {tracker.AVERAGING:g} periods each): "
                "A = sqrt(2 var y), 2 pi f = sqrt(<v^2>/var y), held inside the range.",
                FOLLOWED,
                TEMPERATURE,
                "energyDissipated is the work done on the clamp less the change of what it stores, at the "
                "coefficients of the step, with the force in the middle of each way too; "
                "what a change of A, f or T does to the stored energy is not in it.",
                *(COUNTING for entry in model.further if entry.counted),
                "A step with a value that can't be (NaN or infinite; A, f or T not above 0; a step not above 0) is "
                "discarded with a logged error, the state untouched.",
            ),
        ),
    ]


FOLLOWED = (
    "Where track is false, the law is taken for the A and f that the clamp was told. It sees A and f of its own motion "
    "all the same, cycle by cycle, from reversal to reversal, with the same formulas. forceDeviation is the rms "
    "difference of the whole force along a sinusoid of the motion's A, f and mean, from rest through a second cycle, "
    "between the told A and f and those of the motion (held inside the range), as a share of the latter's rms. Above "
    f"{own_motion.LIMIT:.0%} it is logged once, with what to set: after two such cycles in a row of a motion whose A "
    f"and f change by at most {own_motion.STEADY:.0%} from one to the next, or {own_motion.LASTING} of any other. "
    f"Motions below {own_motion.REST:.0%} of the law's smallest amplitude pass for rest. "
    "With track, and of a law that doesn't depend on A and f, it is 0."
)

TEMPERATURE = (
    "T_in is a tunable parameter beside T, unless the FMU was built with --temperature-input: then it is an input, to "
    "be connected, and useTemperatureInput starts as true."
)

COUNTING = (
    "Load cycles: to firstCycle the clamp adds those that it makes itself, a cycle being a way of four amplitudes "
    "A_used. A step is taken at the cycles that were seen when it began."
)

COEFFICIENTS = (
    "The coefficients law.* are in the law's own units and can be set before and in initialization; "
    "`pipeclamp set-parameters` puts another law's into the FMU."
)

BETWEEN = (
    "From the last communication point to them the motion is the cubic that has displacement and velocity of both "
    "ends. Where the velocity changes sign it turns round once in the step, and memory with it; otherwise the law's "
    "step is straight. So flange.v must be the velocity of flange.s: left at 0, a turn within a step isn't seen, and "
    "its peak is cut off. A master that steps all models in parallel sees the force one step late."
)

PYTHON_USE = (
    f"flange.s and flange.v are the values at the end of a step. {BETWEEN}",
    COEFFICIENTS,
    "States are saved, restored and serialised exactly. Standard library of Python only.",
)
