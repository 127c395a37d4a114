"""What of a measurement may be wrong: sensors (gain, sign, phase, delay, position), excitation, frequency axis."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from math import degrees, exp, log, pi

from pipeclamp_identification.attribution.misstated import displacement_search, moved, place_words
from pipeclamp_identification.attribution.suspect import Side, Suspect, Values
from pipeclamp_identification.on_pipe.instrument import Instrument, SensorChannel
from pipeclamp_identification.on_pipe.measurement import MOTION_UNITS, MeasurementDescription
from pipeclamp_identification.on_pipe.model import CoupledModel

SIDE: Side = "measurement"
GAINS = tuple((side * log(factor),) for factor in (1.1, 1.5, 9.80665, 1e3) for side in (-1, 1))
LARGEST_GAIN = log(2e4)
PHASES = ((-0.2,), (-1.6,), (0.2,), (1.6,), (pi,))
"""rad."""
FULL_TURN = 2 * pi
REVERSED = 0.1
"""rad from half a turn within which a phase is a wrong sign."""
DELAYS = tuple((side * value,) for value in (1.0, 10.0) for side in (-1, 1))
"""ms."""
LONGEST_DELAY = 100.0
RATE_STARTS = tuple((side * value,) for value in (0.01, 0.05) for side in (-1, 1))
MOST_RATE = log(2.0)
SAME_UNIT = 0.03
"""Share within which a gain is that of two units."""

Turned = Callable[[Instrument, SensorChannel], Instrument]
"""Puts what a channel does besides into a measuring chain."""


def measuring_suspects(model: CoupledModel, measurement: MeasurementDescription) -> Iterator[Suspect]:
    """Give all that may be wrong in a measurement with a model's probes."""
    length = model.pipe.pipe.length_m
    names = tuple(probe.name for probe in measurement.probes)
    for index, probe in enumerate(measurement.probes):
        name, words = f"sensor:{probe.name}", f"sensor {probe.name}"
        ratios = {
            f"{unit} recorded, {probe.unit} stated": probe.scale / scale
            for unit, (order, scale) in MOTION_UNITS.items()
            if order == probe.order and unit != probe.unit
        }
        yield _gain(name, words, partial(_on_sensors, (probe.name,)), ratios)
        yield from _late(name, words, partial(_on_sensors, (probe.name,)))
        place = model.pipe.probes[index]
        search = displacement_search(place.position_m, length)
        yield Suspect(
            id=f"{name}.position", side=SIDE, kind="a sensor's position", words=f"the position of {words}",
            change=partial(_moved_probe, probe.name), value_words=partial(place_words, place.position_m),
            starts=search.starts, lower=search.lower, upper=search.upper,
        )  # fmt: skip
    if len(names) > 1:
        yield _gain("sensors", "all sensors", partial(_on_sensors, names), {})
    yield _gain("excitation", "the excitation", _on_excitation, {})
    yield from _late("excitation", "the excitation", _on_excitation)
    at = model.pipe.excitation.position_m
    if at is not None:
        search = displacement_search(at, length)
        yield Suspect(
            id="excitation.position", side=SIDE, kind="the excitation's position", words="where the excitation acts",
            change=_acting_elsewhere, value_words=partial(place_words, at), starts=search.starts, lower=search.lower,
            upper=search.upper,
        )  # fmt: skip
    yield Suspect(
        id="frequency_axis", side=SIDE, kind="the frequency axis", words="the frequency axis (the sampling rate)",
        change=_stretched, value_words=_rate_words, starts=RATE_STARTS, lower=(-MOST_RATE,), upper=(MOST_RATE,),
    )  # fmt: skip


def _gain(name: str, words: str, turned: Turned, ratios: dict[str, float]) -> Suspect:
    def value_words(values: Values, errors: Values) -> str:
        gain = exp(values[0])
        said = f"it reads {gain:.4g} ± {gain * errors[0]:.1g} times the truth"
        units = [unit for unit, ratio in ratios.items() if abs(log(ratio) - values[0]) < SAME_UNIT]
        return f"{said}, as {units[0]} would" if units else said

    return Suspect(
        id=f"{name}.gain", side=SIDE, kind="a calibration", words=f"the calibration of {words}",
        change=partial(_turned, turned, lambda value: SensorChannel(gain=exp(value))), value_words=value_words,
        starts=GAINS, lower=(-LARGEST_GAIN,), upper=(LARGEST_GAIN,),
    )  # fmt: skip


def _late(name: str, words: str, turned: Turned) -> Iterator[Suspect]:
    yield Suspect(
        id=f"{name}.phase", side=SIDE, kind="a phase", words=f"the phase or the sign of {words}",
        change=partial(_turned, turned, lambda value: SensorChannel(phase=value)), value_words=_phase_words,
        starts=PHASES, lower=(-FULL_TURN,), upper=(FULL_TURN,),
    )  # fmt: skip
    yield Suspect(
        id=f"{name}.delay", side=SIDE, kind="a delay", words=f"the delay of {words}",
        change=partial(_turned, turned, lambda value: SensorChannel(delay=1e-3 * value)),
        value_words=lambda values, errors: f"{values[0]:.3g} ± {errors[0]:.1g} ms late",
        starts=DELAYS, lower=(-LONGEST_DELAY,), upper=(LONGEST_DELAY,),
    )  # fmt: skip


def _phase_words(values: Values, errors: Values) -> str:
    phase = degrees(values[0])
    sign = ", its sign is reversed" if abs(abs(values[0]) - pi) < max(REVERSED, errors[0]) else ""
    return f"{phase:.3g} ± {degrees(errors[0]):.1g}° ahead{sign}"


def _rate_words(values: Values, errors: Values) -> str:
    rate = exp(values[0])
    return f"true frequencies are {rate:.5g} ± {rate * errors[0]:.1g} times the stated ones"


def _turned(
    turned: Turned, channel: Callable[[float], SensorChannel], model: CoupledModel, values: Values
) -> CoupledModel:
    if values[0] == 0:
        return model
    return replace(model, instrument=turned(model.instrument, channel(values[0])))


def _on_sensors(names: Iterable[str], instrument: Instrument, more: SensorChannel) -> Instrument:
    for name in names:
        instrument = instrument.with_sensor(name, _after(instrument.sensor(name), more))
    return instrument


def _on_excitation(instrument: Instrument, more: SensorChannel) -> Instrument:
    return replace(instrument, excitation=_after(instrument.excitation, more))


def _after(channel: SensorChannel, more: SensorChannel) -> SensorChannel:
    return SensorChannel(channel.gain * more.gain, channel.phase + more.phase, channel.delay + more.delay)


def _stretched(model: CoupledModel, values: Values) -> CoupledModel:
    if values[0] == 0:
        return model
    instrument = model.instrument
    return replace(model, instrument=replace(instrument, frequency=exp(values[0]) * instrument.frequency))


def _moved_probe(name: str, model: CoupledModel, values: Values) -> CoupledModel:
    if values[0] == 0:
        return model
    probes = tuple(moved(probe, values[0]) if probe.name == name else probe for probe in model.pipe.probes)
    return replace(model, pipe=model.pipe.model_copy(update={"probes": probes}))


def _acting_elsewhere(model: CoupledModel, values: Values) -> CoupledModel:
    stated = model.pipe.excitation
    if values[0] == 0 or stated.position_m is None:
        return model
    excitation = stated.model_copy(update={"position_m": stated.position_m + values[0]})
    return replace(model, pipe=model.pipe.model_copy(update={"excitation": excitation}))
