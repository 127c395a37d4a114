"""The clamp as an FMI 2.0 co-simulation slave on the standard library alone.

The builder makes one module of this file, `tracker`, `own_motion`, `within_step`, `plain`, `values_file` and a
generated law in place of `stand_in_law`, and gives the class a name of its own, since all Python FMUs of a process
share one interpreter. The law's numbers are not in the module: each instance reads those in its FMU's resources.

Inputs are the values at the end of the step; `within_step` says what the motion is between two communication points.
"""

from __future__ import annotations

import math
from typing import Any

from pythonfmu.enums import Fmi2Status

from pipeclamp_fmu.slaves.own_motion import (
    BEGIN,
    LASTING,
    LIMIT,
    NOTHING_SEEN,
    OFF_BY,
    REST,
    STEADY,
    Cycle,
    Seen,
    compared_already,
    ended,
    force_deviation,
    near,
)
from pipeclamp_fmu.slaves.plain import Fmi2Slave
from pipeclamp_fmu.slaves.stand_in_law import (
    COEFFICIENTS,
    COUNTED,
    FURTHER,
    PARTS,
    STATES,
    coefficients,
    step,
)
from pipeclamp_fmu.slaves.values_file import read_values
from pipeclamp_models.steps.tracker import RIPPLE, SLACK, Interval, held, start_tracking, tracked
from pipeclamp_models.steps.within_step import walk

MM = 1000.0
"""mm in a metre: the law is in mm, the FMU's boundary in m."""

LAW = "law."
"""What the names of the law's coefficients begin with."""

INPUTS = ("flange.s", "flange.v", "T_in")
PARAMETERS = ("A", "f", "T", *[name for name, *_ in FURTHER])
OUTPUTS = ("flange.f", "A_used", "f_used", "T_used", "energyDissipated", "forceDeviation")
FIXED = tuple([f"{LAW}{name}" for name in COEFFICIENTS])
S, V, T_IN, A, F, T = range(6)
FIRST_FURTHER = T + 1
FORCE = FIRST_FURTHER + len(FURTHER)
FIRST_FIXED = FORCE + len(OUTPUTS)
FORCE, A_USED, F_USED, T_USED, DISSIPATED, DEVIATION = range(FORCE, FIRST_FIXED)
POSITIVE = tuple([place for place, (_, _, _, positive) in enumerate(FURTHER, FIRST_FURTHER) if positive])
UNITS = (" mm", " Hz", " K", *[unit and f" {unit}" for _, unit, _, _ in FURTHER])
SCALES = tuple([scale for _, _, scale, _ in FURTHER])

BOOLEAN_PARAMETERS = ("useTemperatureInput", "track")
BOOLEAN_LOCALS = ("inRange",)
USE_T_IN, TRACK, IN_RANGE = range(3)

HUGE = 1e30
"""A value beyond it is a mistake, whatever the unit; below it, powers that laws take of it don't overflow."""

AT_REST = tuple([start for _, start in STATES])
"""The law's memory before anything has moved."""

AT_START: Motion = ((), 0.0, 0.0, 0.0, 0.0, AT_REST)
"""The motion of a clamp that has not been started."""

NO_VALUE = (ArithmeticError, TypeError, ValueError)
"""What a law raises where it has no value, far outside its range."""

NO_VALUE_THERE = "the law has no value there"

Motion = tuple[Any, float, float, float, float, tuple[float, ...]]
Conditions = tuple[float, float, float, tuple[float, ...], tuple[float, ...] | None]


def within(value: float, interval: Interval, slack: float = SLACK) -> bool:
    """Tell whether the value lies in the range, but for rounding, or for the ripple of what is followed."""
    low, high = interval
    return low - slack * abs(low) <= value <= high + slack * abs(high)


def slack_of(place: int, conditions: Conditions) -> float:
    """Give the share by which A (place 0), f (1) or a later condition may pass the end of its range."""
    return RIPPLE if place < T - A and conditions[4] is not None else SLACK


def in_use(conditions: Conditions, ranges: tuple[Interval, ...]) -> tuple[float, ...]:
    """Give A, f, T and further conditions for the law: as set, or as tracked but held inside the law's range."""
    amplitude, frequency, temperature, further, averages = conditions
    if averages is None:
        return amplitude, frequency, temperature, *further
    return held(amplitude, ranges[0]), held(frequency, ranges[1]), temperature, *further


class ClampSlave(Fmi2Slave):
    """A pipe clamp: force from displacement, velocity and temperature.

    Attributes:
        _law: the law's name, for messages.
        _ranges: where its data lie: A (mm), f (Hz), T (K), further conditions.
        _farthest: farthest displacement that they hold, mm.
        _motion: coefficients, y, v, force, stored energy and memory at the last communication point, as the law has
            them (mm, N, s).
        _conditions: A (mm), f (Hz), T (K) of the motion, before they are held inside the range; further conditions; the
            tracker's averages.
        _counted: load cycles since the start: a cycle is a way of four amplitudes, there and back.
        _inside: whether the conditions are inside the law's range.
        _follows: whether the law depends on A or f, and they are told.
        _cycle, _seen: of the clamp's own motion, where that is so.
    """

    KEPT = ("_motion", "_conditions", "_counted", "_inside", "_follows", "_cycle", "_seen")

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(INPUTS, PARAMETERS, OUTPUTS, BOOLEAN_PARAMETERS, BOOLEAN_LOCALS, kwargs, FIXED)
        ends = ("minimum", "maximum") * len(PARAMETERS)
        names = (*INPUTS, *PARAMETERS, *FIXED, *BOOLEAN_PARAMETERS, *ends)
        self._law, numbers = read_values(str(self.resources), names)
        first_flag = FORCE + len(FIXED)
        first_end = first_flag + len(BOOLEAN_PARAMETERS)
        self._ranges: tuple[Interval, ...] = tuple(zip(numbers[first_end::2], numbers[first_end + 1 :: 2], strict=True))
        self._farthest = self._ranges[0][1] * (1 + SLACK)
        self._reals[:FORCE], self._reals[FIRST_FIXED:] = numbers[:FORCE], numbers[FORCE:first_flag]
        self._flags[: len(BOOLEAN_PARAMETERS)] = map(bool, numbers[first_flag:first_end])
        self._signals = T_IN  # a new temperature is a new condition, as a new parameter is
        self._motion: Motion = AT_START
        self._counted = 0.0
        self._conditions: Conditions = (*self._scaled(T), None)
        self._inside = self._flags[IN_RANGE] = True
        self._follows = False
        self._cycle: Cycle = BEGIN
        self._seen: Seen = NOTHING_SEEN
        self._warned = self._warned_of_motion = False  # not part of a saved state: what was said stays said

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Move to the inputs' displacement and velocity; refuse what can't be, the state untouched."""
        reals = self._reals
        y = MM * reals[S]
        v = MM * reals[V]
        settled = self._settled
        if settled and 0.0 < step_size < math.inf and -HUGE < y < HUGE and -HUGE < v < HUGE:
            k, y_before, v_before, force_before, energy_before, memory = self._motion
        else:
            prepared = self._prepare(step_size, y, v)
            if isinstance(prepared, str):
                return self._refuse(current_time, step_size, prepared)
            conditions, (k, y_before, v_before, force_before, energy_before, memory) = prepared
        motion, begun = (y_before, v_before, y, v), (force_before, energy_before)
        try:
            force, energy, memory, lost, way = walk(step, k, memory, motion, step_size, begun, PARTS)
        except NO_VALUE:
            return self._refuse(current_time, step_size, NO_VALUE_THERE)
        total = force + energy + lost
        if total - total != 0.0:
            return self._refuse(current_time, step_size, NO_VALUE_THERE)
        if not settled:
            self._take(conditions)
        reals[FORCE] = force
        reals[DISSIPATED] += 0.001 * lost  # N mm to J
        self._motion = (k, y, v, force, energy, memory)
        if COUNTED >= 0:
            self._counted += way / (4.0 * MM * reals[A_USED])
        self._flags[IN_RANGE] = inside = self._inside and abs(y) <= self._farthest
        if not (inside or self._warned):
            self._warn(y)
        if self._follows and self._conditions[4] is None:
            time, mean, square, speed = self._cycle
            self._cycle = (
                time + step_size,
                mean + step_size * y,
                square + step_size * (y * y),
                speed + step_size * (v * v),
            )
            if (v < 0.0) != (v_before < 0.0):
                self._turn_round()
        return True

    def _turn_round(self) -> None:
        """At a reversal of the motion: where it ends a cycle, tell how far the force is off for the A and f told."""
        begun, A_before, f_before, off, compared = self._seen
        found = ended(self._cycle, A_before) if begun else BEGIN[:3]
        if found is None:
            return
        A, f, mean = found
        self._cycle = BEGIN
        if f == 0.0 or REST * self._ranges[0][0] > A:
            self._seen = (True, A, 0.0, 0, ())
            self._reals[DEVIATION] = 0.0
            return
        k = self._motion[0]
        if not compared_already(compared, A, f, mean, k):
            compared = (A, f, mean, k)
            self._reals[DEVIATION] = self._deviation(k, A, f, mean)
        off = off + 1 if self._reals[DEVIATION] > LIMIT else 0
        self._seen = (True, A, f, off, compared)
        steady = near(A, A_before, STEADY, A) and near(f, f_before, STEADY, f)
        if ((off >= 2 and steady) or off >= LASTING) and not self._warned_of_motion:
            self._warn_of_motion(A, f)

    def _deviation(self, k: Any, A: float, f: float, mean: float) -> float:
        """Give how far the force is off with coefficients k on a motion, see `force_deviation`."""
        _, _, temperature, further, _ = self._conditions
        try:
            held_A, held_f = held(A, self._ranges[0]), held(f, self._ranges[1])
            own = coefficients(self._reals[FIRST_FIXED:], held_A, held_f, temperature, *further)
            return force_deviation(step, k, own, AT_REST, A, f, mean)
        except NO_VALUE:
            return 0.0

    def _warn_of_motion(self, A: float, f: float) -> None:
        """Say once that the motion isn't the one that A and f tell of."""
        self._warned_of_motion = True
        told_A, told_f, *_ = self._conditions
        held_A, held_f = held(A, self._ranges[0]), held(f, self._ranges[1])
        self.log(
            f"law {self._law} is told A = {told_A:.3g} mm, f = {told_f:.3g} Hz, and the motion has A = {A:.3g} mm, "
            f"f = {f:.3g} Hz: {OFF_BY} {100.0 * self._reals[DEVIATION]:.1f} percent; "
            f"set A = {held_A / MM:.3g} m and f = {held_f:.3g} Hz, or track = true",
            Fmi2Status.warning,
        )

    def _settings(self) -> tuple[float, float, float, tuple[float, ...]] | str:
        """Give A (mm), f (Hz), T (K) and further conditions, or what is wrong with state, inputs or parameters."""
        if self._lost:
            return self._lost
        reals = self._reals
        names = INPUTS + PARAMETERS
        for name, value in zip(names, reals, strict=False):
            if not -HUGE < MM * value < HUGE:
                return f"{name} is {value:g}; expected a number between -{HUGE / MM:g} and {HUGE / MM:g}"
        temperature = T_IN if self._flags[USE_T_IN] else T
        for index, unit in ((A, "m"), (F, "Hz"), (temperature, "K")):
            if reals[index] <= 0.0:
                return f"{names[index]} is {reals[index]:g} {unit}; expected a value above 0 {unit}"
        for index in POSITIVE:
            if reals[index] <= 0.0:
                return f"{names[index]} is {reals[index]:g}; expected a value above 0"
        return self._scaled(temperature)

    def _scaled(self, temperature: int) -> tuple[float, float, float, tuple[float, ...]]:
        """Give A (mm), f (Hz), T (K) and further conditions as they are set, the temperature from a variable."""
        reals = self._reals
        further = [scale * value for scale, value in zip(SCALES, reals[FIRST_FURTHER:FORCE], strict=True)]
        if COUNTED >= 0:
            further[COUNTED] += self._counted
        return MM * reals[A], reals[F], reals[temperature], tuple(further)

    def _prepare(self, step_size: float, y: float, v: float) -> tuple[Conditions, Motion] | str:
        """Give the conditions of the step and what it starts from, or why it can't be; nothing is changed."""
        if not (step_size > 0.0 and math.isfinite(step_size)):
            return "expected a finite step above 0 s"
        settings = self._settings()
        if isinstance(settings, str):
            return settings
        conditions: Conditions = (*settings, None)
        if self._flags[TRACK]:
            averages = self._conditions[4] or start_tracking(*settings[:2])
            A, f, averages = tracked(averages, step_size, self._conditions[1], self._ranges, y, v)
            conditions = (A, f, *settings[2:], averages)
        motion = self._under(conditions, self._motion)
        return motion if isinstance(motion, str) else (conditions, motion)

    def _under(self, conditions: Conditions, motion: Motion) -> Motion | str:
        """Give a motion as it stands under other conditions, or say that the law has no value there.

        Force and stored energy at the old place are those of the new coefficients, so that what a change of
        conditions does to the stored energy is not taken for dissipation.
        """
        k, y, v, _, _, memory = motion
        try:
            after = coefficients(self._reals[FIRST_FIXED:], *in_use(conditions, self._ranges))
            if after == k:
                return motion
            force, energy, _ = step(after, memory, y, y, v, 0.0)
            if all(map(math.isfinite, (*after, force, energy))):
                return (after, y, v, force, energy, memory)
        except NO_VALUE:
            pass
        return f"the law has no value at A = {conditions[0]:g} mm, f = {conditions[1]:g} Hz"

    def _take(self, conditions: Conditions) -> None:
        """Keep the conditions and show what is used of them."""
        reals = self._reals
        amplitude, reals[F_USED], reals[T_USED], *_ = in_use(conditions, self._ranges)
        reals[A_USED] = amplitude / MM
        self._conditions = conditions
        values = zip((*conditions[:3], *conditions[3]), self._ranges, strict=False)
        self._inside = all(within(*one, slack_of(place, conditions)) for place, one in enumerate(values))
        self._settled = conditions[4] is None and COUNTED < 0  # else the next step is under other conditions
        if conditions[4] is not None:
            self._forget_motion()

    def _depends_on_motion(self) -> bool:
        """Tell whether the law's coefficients differ at the corners of its range of A and f from the present ones."""
        _, _, temperature, further, _ = self._conditions
        fixed = self._reals[FIRST_FIXED:]
        try:
            return any(
                coefficients(fixed, A, f, temperature, *further) != self._motion[0]
                for A in self._ranges[0]
                for f in self._ranges[1]
            )
        except NO_VALUE:
            return True

    def _forget_motion(self) -> None:
        """Begin to look at the clamp's own motion anew."""
        self._cycle, self._seen = BEGIN, NOTHING_SEEN
        self._reals[DEVIATION] = 0.0

    def _evaluate_start(self) -> None:
        """Evaluate the law at the present inputs and parameters, with fresh memory."""
        settings = self._settings()
        if isinstance(settings, str):
            self.log(f"start values: {settings}", Fmi2Status.error)
            return
        conditions: Conditions = (*settings, start_tracking(*settings[:2]) if self._flags[TRACK] else None)
        y, v = MM * self._reals[S], MM * self._reals[V]
        motion = self._under(conditions, ((), y, v, 0.0, 0.0, AT_REST))
        if isinstance(motion, str):
            self.log(f"start values: {motion}", Fmi2Status.error)
            return
        self._motion = motion
        self._take(conditions)
        self._forget_motion()
        self._follows = self._depends_on_motion()
        self._reals[FORCE] = motion[3]
        self._flags[IN_RANGE] = self._inside and abs(y) <= self._farthest

    def _warn(self, y: float) -> None:
        """Say once where the law is used beyond its data."""
        self._warned = True
        amplitude, frequency, temperature, further, _ = self._conditions
        names, units = (*PARAMETERS, "|flange.s|"), (*UNITS, UNITS[0])
        values = (amplitude, frequency, temperature, *further, abs(y))
        intervals = (*self._ranges, (0.0, self._ranges[0][1]))
        outside = [
            f"{name} = {value:.6g}{unit} is outside {low:g} to {high:g}{unit}"
            for place, (name, value, (low, high), unit) in enumerate(zip(names, values, intervals, units, strict=True))
            if not within(value, (low, high), slack_of(place, self._conditions))
        ]
        self.log(f"law {self._law} is used beyond its range: {'; '.join(outside)}", Fmi2Status.warning)
