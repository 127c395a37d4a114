"""The force of a clamp along a motion that somebody gives, in the units of tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError, did_you_mean
from pipeclamp_models.base.signals import REFERENCES, column_of, signal_of
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Equations, Law
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.realise.scalar_law import parts_of_law
from pipeclamp_models.steps.ways import ways_along

ALWAYS = ("A", "f", "T")
"""Conditions that may be given to every law, whether it follows them or not."""


REAL = "biufO"
"""Kinds of arrays that hold real numbers: of truth values, integers, floats, or of Python's own objects."""


def force_along(
    file: LawFile, y: npt.ArrayLike, v: npt.ArrayLike, given: Mapping[str, npt.ArrayLike], h: float | None
) -> Array | np.float64:
    """Give the clamp's force along a motion from rest; effects of the rig stay out.

    Args:
        file: the law.
        y: displacement in mm, shape (..., n) or (); samples in time along the last axis where the law has memory.
        v: velocity in mm/s, of a shape that broadcasts with it.
        given: conditions by name: A mm, f Hz, T degC, density_g_cm3, first_cycle, columns of runs.csv; shapes likewise.
        h: seconds between samples, by which the law goes from one to the next as an FMU goes through its step; None
            where they aren't known: each is one straight move.

    Returns:
        force in N, of the shape that y and v have together.

    Raises:
        UserError: the law follows a condition that isn't given, doesn't know one that is, or needs `h`.
    """
    law = law_of(file)
    equations = law.structure.equations_without_rig
    if "T" not in file.range:  # its tests told none, so that it follows none
        given = {"T": REFERENCES["T_0"] - CELSIUS, **given}
    slow = _slow(file.name, equations, given)
    y, v = _finite("y", y), _finite("v", v)
    try:
        shape = np.broadcast_shapes(y.shape, v.shape)
        slow = {name: np.broadcast_to(values, shape) for name, values in slow.items()}
    except ValueError as error:
        raise UserError(f"force: {error}; expected y, v and conditions of shapes that go together") from error
    if 0 in shape:
        return np.zeros(shape)
    rows = (-1, shape[-1]) if shape else (1, 1)
    y, v = np.broadcast_to(y, shape), np.broadcast_to(v, shape)
    slow = {name: values.reshape(rows) for name, values in slow.items()}
    steps = np.full((y.size // rows[1], 1), _step(file.name, equations, h))
    y, v = y.reshape(rows), v.reshape(rows)
    motion = Motion(y, v, np.zeros_like(y), slow, steps, periodic=False)
    if h is not None and equations.states:
        parts = _parts(file, law, slow, y, h)
        motion = replace(motion, ways=ways_along(y, v, steps, motion.rest, parts))
    force = force_of_equations(equations, law.vector(equations), (law.v_r, law.y_r), motion).force
    return force.reshape(shape) if shape else np.float64(force[0, 0])


def _parts(file: LawFile, law: Law, slow: Mapping[str, Array], y: Array, h: float) -> int:
    """Give in how many parts an FMU of the law walks its steps; where the file tells no range, that of the motion."""
    largest = {"A": float(np.abs(y).max()), "f": 1 / (h * y.shape[1])}
    A, f = (file.range[name].maximum if name in file.range else largest[name] for name in largest)
    means = {"T": REFERENCES["T_0"], **{name: float(np.mean(values)) for name, values in slow.items()}}
    return parts_of_law(law, means, A, f)


def _finite(name: str, values: npt.ArrayLike) -> Array:
    """Give numbers as an array.

    Raises:
        UserError: they aren't numbers, or not all are finite.
    """
    try:
        array = np.asarray(values)
        if array.dtype.kind not in REAL:  # numpy would turn texts, dates and complex numbers into some number
            raise TypeError(array.dtype)
        array = np.ma.filled(np.ma.asarray(values, dtype=np.float64), np.nan)
    except (TypeError, ValueError) as error:
        raise UserError(f"force: {name}: got {values!r}; expected numbers") from error
    if not np.all(np.isfinite(array)):
        place = np.argwhere(~np.isfinite(array))[0].tolist()
        at = f" at index {', '.join(map(str, place))}" if place else ""
        got = array[tuple(place)]
        raise UserError(f"force: {name}: got {got:g}{at}; expected finite numbers")
    return array


def _slow(law: str, equations: Equations, given: Mapping[str, npt.ArrayLike]) -> dict[str, Array]:
    """Give the conditions that a law follows, by the names of their signals.

    Raises:
        UserError: one isn't given, or one is given that the law doesn't know.
    """
    follows = equations.slow_signals
    signals = {name: _signal(name) for name in given}
    for name, signal in signals.items():
        if signal not in follows and name not in ALWAYS:
            columns = [*ALWAYS, *map(column_of, sorted(follows))]
            raise UserError(
                f"force: law {law} doesn't follow {name!r}; {did_you_mean(name, columns)}expected of "
                f"{', '.join(dict.fromkeys(columns))}"
            )
    values = {signals[name]: _finite(name, value) for name, value in given.items()}
    if absent := [column_of(signal) for signal in sorted(follows - set(values))]:
        given_not = "which isn't given" if len(absent) == 1 else "which aren't given"
        expected = ", ".join(f"{name}=..." for name in absent)
        raise UserError(f"force: law {law} follows {', '.join(absent)}, {given_not}; expected {expected}")
    for name in ("A", "f"):
        if name in values and np.any(values[name] <= 0):
            raise UserError(f"force: {name}: got {np.min(values[name]):g}; expected numbers above 0")
    if "T" in values:
        values["T"] = values["T"] + CELSIUS
        if np.any(values["T"] <= 0):
            raise UserError(f"force: T: got {np.min(given['T']):g} °C; expected temperatures above 0 K")
    return {signal: values[signal] for signal in follows}


def _signal(name: str) -> str:
    return name if name in ALWAYS else signal_of(name)


def _step(law: str, equations: Equations, h: float | None) -> float:
    """Give the seconds between samples, which only states that fade with time ask for.

    Raises:
        UserError: they aren't known but asked for, or no positive number.
    """
    if h is None:
        if equations.outline.fades:
            raise UserError(
                f"force: law {law} has memory that fades with time; expected h=, the seconds between samples"
            )
        return 1.0
    if not (np.isfinite(h) and h > 0):
        raise UserError(f"force: h: got {h!r}; expected the seconds between samples, above 0")
    return float(h)
