"""What an excitation's FMU is made of, from samples at equal steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipeclamp_fmu.contents.content import Content
from pipeclamp_fmu.describe.documentation import page
from pipeclamp_fmu.describe.model_description import ModelText, Quantity, usual
from pipeclamp_fmu.slaves import excitation as excitation_slave
from pipeclamp_fmu.slaves.one_module import source_text, with_inlined


@dataclass(frozen=True)
class Samples:
    """An excitation: values at equal steps (s) from time 0, in `unit`."""

    step: float
    values: Sequence[float]
    unit: str


def excitation_text(samples: Samples, version: str) -> ModelText:
    """Give what the description says of the whole."""
    return ModelText("Excitation", "Signal over time, linear between its samples", version, samples.step)


def signal_quantity(samples: Samples) -> Quantity:
    """Give what an importer should know of the signal."""
    highest = max(map(abs, samples.values)) or 1.0
    return Quantity("excitation", samples.unit, "", -10 * highest, 10 * highest, usual(highest))


def excitation_documentation(samples: Samples) -> str:
    """Give the page that travels inside the FMU."""
    text = f"{len(samples.values)} samples, {samples.step:g} s apart, linear between, zero after the last."
    return page(excitation_text(samples, "").title, (text,), ())


def excitation_content(samples: Samples, version: str) -> Content:
    """Give all that goes into the excitation's Python FMU."""
    generated = f"STEP = {float(samples.step)!r}\nVALUES = {tuple(map(float, samples.values))!r}\n"
    return Content(
        kind="excitation",
        source=with_inlined(
            source_text("pipeclamp_fmu.slaves.excitation"),
            {
                "pipeclamp_fmu.slaves.plain": source_text("pipeclamp_fmu.slaves.plain"),
                "pipeclamp_fmu.slaves.stand_in_samples": generated,
            },
        ),
        class_name=excitation_slave.ExcitationSlave.__name__,
        text=excitation_text(samples, version),
        quantities={"signal": signal_quantity(samples)},
        initially={},
        documentation=excitation_documentation(samples),
    )
