"""What can be hidden in a truth: every effect in the catalogue's form (clean) and in another (rough).

`slip_speed` is hidden in devices alone (`devices/`), for it needs another effect, whose slip force it changes; so does
`slip_temperature`, which isn't hidden. `slip_lock` and `relaxation_temperature` are hidden in devices alone, too.

Each function takes the motion, the base law, the form, the size and the drawn shape, and gives the effect's Part.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from truth import (
    T0,
    Array,
    BaseLaw,
    Motion,
    Part,
    behind_clearance,
    bouc_wen,
    first_order,
    flag,
    iwan,
    jenkins,
    jenkins_of_two_limits,
    late,
    maxwell,
    maxwell_arms,
    relieved,
)

Shape = Mapping[str, float]

SHORTEST_COLUMN = 1.6
"""Length of a gas column in mm at least: a proposed test goes to 1.5 mm (`judge.RIG_LIMITS`), no gas beyond its end."""


@dataclass(frozen=True)
class Kind:
    """A kind of hidden physics.

    Attributes:
        part: gives what it does.
        start: a small size to begin the search for its strength with.
        most: largest reasonable size.
        needs: "" or what the campaign must vary for it: "density", "condition", "cycles".
        rough_is: another effect that its rough form is as much as its own: two relaxation times are a spread of them,
            so are fourteen slip forces, and dry friction that is smoothed is rounded.
    """

    part: Callable[[Motion, BaseLaw, bool, float, Shape], Part]
    start: float = 0.01
    most: float = 0.5
    needs: str = ""
    rough_is: str = ""


def typical(base: BaseLaw) -> float:
    """Give a typical force in N, by which sizes are stated."""
    return base.k10 * 0.8


def softly(x: Array, width: float | Array) -> Array:
    """Give (x)+ with a rounded corner of this width."""
    return np.logaddexp(0.0, x / width) * width


def memory(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Elastic-slip elements; rough: slip spread over 14 elements."""
    if rough:
        limits = shape["limit"] * np.geomspace(0.35, 2.2, 14)
    elif shape["several"] > 0.5:
        limits = shape["limit"] * np.array([0.5, 1.6])
    else:
        limits = shape["limit"] * np.ones(1)
    elements = motion.remember(("memory", rough), lambda: jenkins(motion, limits))
    return Part(force=size * base.k10 * elements)


def directional_slip(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """An elastic-slip element with another limit each way; rough: two of them, that slip early and late."""
    up, down = (shape["limit"] * share for share in ((1.3, 0.5) if shape["sign"] > 0 else (0.5, 1.3)))

    def element() -> Array:
        parts = (0.8, 1.2) if rough else (1.0,)
        return np.mean([jenkins_of_two_limits(motion, part * up, part * down) for part in parts], axis=0)

    return Part(force=size * base.k10 * motion.remember(("directional_slip", rough), element))


def slip_spread(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Slip displacements spread by a power (Iwan), with a peak; rough: without one."""
    chi, peak = -0.7 + 0.5 * shape["any"], 0.0 if rough else 0.25
    spread = motion.remember(("slip_spread", rough), lambda: iwan(motion, 2.5 * shape["limit"], chi, peak, 40))
    return Part(force=size * base.k10 * spread)


def bouc_wen_pinched(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Bouc-Wen hysteresis with pinching; rough: slip-lock as a factor on the stiffness, past zero force (Foliente)."""
    n, limit, width = 1.0 + 1.5 * shape["any"], shape["limit"], 0.3

    def hysteresis() -> Array:
        if rough:
            return bouc_wen(motion, limit, n, lambda z, side: 1 - 0.7 * np.exp(-(((z * side - 0.05) / width) ** 2)))
        z = bouc_wen(motion, limit, n)
        return z * (1 - 0.5 * np.exp(-((z / (width * limit)) ** 2)))

    return Part(force=size * base.k10 * motion.remember(("bouc_wen", rough), hysteresis))


def coulomb(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Dry friction; rough: smoothed, and a little more of it where the displacement presses harder."""
    F_c = size * typical(base)
    if not rough:
        return Part(force=F_c * np.sign(motion.v))
    level = 1 + 0.1 * motion.y**2
    return Part(force=F_c * level * np.tanh(motion.v / (0.03 * shape["speed"])))


def rounded_friction(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Friction that turns over within a speed, by a hyperbolic tangent; rough: by a root."""
    speed = motion.v / (2 * shape["speed"])
    return Part(force=size * typical(base) * (speed / np.hypot(speed, 1.0) if rough else np.tanh(speed)))


def displacement_friction(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Friction as what deflects presses; rough: smoothed, and pressed a little at rest."""
    pressed = np.abs(motion.y) + (0.05 * shape["stop"] if rough else 0.0)
    slides = np.tanh(motion.v / (0.03 * shape["speed"])) if rough else np.sign(motion.v)
    return Part(force=size * base.k10 * pressed * slides)


def pressed_slip(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Slip that displacement presses, on one side more; rough: many elements that slip early and late."""
    limits = 0.5 * shape["limit"] * (np.geomspace(0.5, 2.0, 9) if rough else np.ones(1))
    parts = [1 + 0.5 * shape["sign"], 1 - 0.5 * shape["sign"]]
    pressed = 0.1 * shape["stop"] + np.where(motion.y > 0, parts[0], parts[1]) * np.abs(motion.y)

    def carried() -> Array:
        return np.mean([jenkins(motion, np.array([limit])) / limit for limit in limits], axis=0)

    return Part(force=size * base.k10 * pressed * motion.remember(("pressed_slip", rough), carried))


def self_centring(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A flag on each side; rough: several that give way early and late, so that its corners are round."""
    limits = shape["limit"] * (np.linspace(0.6, 1.4, 5) if rough else np.ones(1))
    back = 1 - (0.3 + 0.4 * shape["any"])

    def flags() -> Array:
        return np.mean([flag(motion, limit, back * limit) for limit in limits], axis=0)

    return Part(force=size * base.k10 * motion.remember(("self_centring", rough), flags))


def stribeck(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Dry friction that falls with speed, as a Gaussian; rough: as Hess and Soom have it, smoothed."""
    speed, at_speed = np.abs(motion.v) / (4 * shape["speed"]), 0.3 * shape["any"]
    if rough:
        return Part(force=size * typical(base) * (at_speed + 1 / (1 + speed**2)) * np.tanh(motion.v / 0.05))
    return Part(force=size * typical(base) * (at_speed + np.exp(-(speed**2))) * np.sign(motion.v))


def viscous(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Viscous damping; rough: a power near one."""
    speed = motion.v / 20.0
    power = 0.93 + 0.14 * shape["any"] if rough else 1.0
    return Part(force=size * typical(base) * np.copysign(np.abs(speed) ** power, speed))


def quadratic_damping(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Air pumped through the mesh; rough: another power."""
    speed = motion.v / 20.0
    power = 1.85 + 0.35 * shape["any"] if rough else 2.0
    return Part(force=size * typical(base) * np.copysign(np.abs(speed) ** power, speed))


def directional_damping(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Damping that differs with direction; rough: a smooth change."""
    side = np.tanh(motion.v / shape["speed"]) if rough else np.sign(motion.v)
    return Part(damping=1 + size * side)


def asymmetry(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Halves pressed unequally; rough: levels off to a bilinear law."""
    size = size * np.copysign(1.0, shape["sign"])
    if rough:
        return Part(force=size * base.k10 * motion.y * np.tanh(motion.y / 1.2) * 1.2)
    return Part(force=size * base.k10 * motion.y**2)


def hardening(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Fifth power; rough: another power."""
    power = 4.5 + 1.2 * shape["any"] if rough else 5.0
    return Part(force=size * base.k10 * np.copysign(np.abs(motion.y) ** power, motion.y))


def exponential_stiffening(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stiffness that grows as an exponential of the stroke; rough: as a hyperbolic cosine."""
    rate = (2.5 + 3.5 * shape["any"]) / shape["stop"]
    stroke = rate * np.abs(motion.y)
    grown = np.sinh(stroke) if rough else np.expm1(stroke)
    return Part(force=size * base.k10 * np.sign(motion.y) * (grown - stroke) / rate)


def gas_spring(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Gas in a column, polytropic; rough: on a bellows, of which the area grows as it is compressed."""
    column = max(shape["stop"] / (0.3 + 0.3 * shape["any"]), SHORTEST_COLUMN)
    share = motion.y / column * np.copysign(1.0, shape["sign"])
    area = 1 + 0.2 * share if rough else 1.0
    return Part(force=size * typical(base) * (area * (1 - share) ** -1.35 - 1))


def end_stop(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stop; rough: soft."""
    beyond = np.abs(motion.y) - shape["stop"]
    pressed = softly(beyond, 0.02) if rough else np.maximum(beyond, 0.0)
    return Part(force=size * base.k10 * np.sign(motion.y) * pressed)


def unilateral_contact(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stop on one side that pushes and damps; rough: a spring with a dashpot that gives at most the spring's force."""
    side, per_speed = np.copysign(1.0, shape["sign"]), 0.01 * shape["ratio"]
    depth = np.maximum(side * motion.y - shape["stop"], 0.0)
    towards = side * motion.v
    if rough:
        pushed = depth + np.clip(shape["stop"] * per_speed * towards, -depth, depth)
    else:
        pushed = depth ** (1 + 0.5 * shape["any"]) * np.maximum(1 + per_speed * towards, 0.0)
    return Part(force=size * base.k10 * side * pushed)


def gap(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Clearance before the elastic path engages; rough: rounded."""
    if rough:
        return Part(x=motion.y - size * np.tanh(motion.y / (0.8 * size)))
    return Part(x=np.sign(motion.y) * np.maximum(np.abs(motion.y) - size, 0.0))


def play(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Clearance before the whole clamp; rough: before each half of it, of another width."""
    widths = (0.7 * size, 1.3 * size) if rough else (size,)
    return Part(ends=tuple(behind_clearance(motion, base, width) for width in widths))


def relaxation(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Maxwell arm; rough: two of them."""
    taus = (shape["tau"] / 1.7, shape["tau"] * 1.7) if rough else (shape["tau"],)
    arms = [motion.remember(("maxwell", tau), lambda tau=tau: maxwell(motion, tau)) for tau in taus]
    return Part(force=size * base.k10 * np.mean(arms, axis=0))


def relaxation_spread(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Relaxation times spread as Cole and Cole's (fractional); rough: evenly in their logarithm, over two decades."""
    places = np.log(10) * (np.linspace(-1.0, 1.0, 15) if rough else np.arange(-3.0, 3.1, 0.3))
    order = 0.45 + 0.3 * shape["any"]
    spread = 1 / (np.cosh(order * places) + np.cos(np.pi * order))
    weights = np.full(len(places), 1 / len(places)) if rough else spread / spread.sum()
    taus = shape["tau"] * np.exp(places)
    arms = motion.remember(("relaxation_spread", rough), lambda: maxwell_arms(motion, taus, weights))
    return Part(force=size * base.k10 * arms)


def inner_mass(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Mass inside on a spring that resonates among the tests, in its steady state; rough: two of them, apart."""
    frequency, losses = 2.0 + 3.0 * shape["any"], 0.15 + 0.35 * shape["several"]
    force = np.zeros_like(motion.y)
    own = np.array([0.8, 1.25] if rough else [1.0]) * 2 * np.pi * frequency
    for order, tone in motion.tones:
        w = 2 * np.pi * order * motion.f
        follows = np.mean([turn**2 / (turn**2 - w**2 + 2j * losses * turn * w) for turn in own])
        force += np.real((1 - follows) * tone[:, None] * np.exp(1j * w * motion.time))
    return Part(force=size * base.k10 * force)


def oil_damper(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Oil damper with a relief valve; rough: a valve that opens little by little."""
    relief, opened = size * typical(base), 20.0 * shape["any"] + 5.0
    exponent, slope = 0.5 + 0.5 * shape["several"], 0.1 + 0.2 * shape["any"]

    def speed_under(force: Array) -> Array:
        load = np.abs(force) / relief
        beyond = softly(load - 1, 0.1) if rough else np.maximum(load - 1, 0.0)
        return opened * np.sign(force) * (np.minimum(load, 1.0) ** (1 / exponent) + beyond / (slope * exponent))

    return Part(force=relieved(motion, relief / (0.4 * shape["limit"]), speed_under, relief))


def damping_temperature(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Damping over temperature; rough: falls by a smooth step, or into a valley."""
    t = (motion.T - T0) / 100
    size = size * np.copysign(1.0, shape["sign"])
    if not rough:
        return Part(damping=np.exp(size * (t - 0.35 * shape["any"] * t**2)))
    if shape["several"] > 0.5:
        return Part(damping=1 + size * (1 + np.tanh((motion.T - 420) / 60)))
    return Part(damping=1 - size * np.exp(-(((motion.T - 440) / 80) ** 2)))


def contact_growth(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stiffness that rises above a temperature; rough: smoothly."""
    above = motion.T - shape["contact"]
    grown = softly(above, 20.0) if rough else np.maximum(above, 0.0)
    return Part(stiffness=1 + size * grown / 100)


def stiffness_frequency(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stiffness over frequency; rough: straight rather than a power."""
    size = size * np.copysign(1.0, shape["sign"])
    if rough:
        return Part(stiffness=1 + size * (np.log1p(motion.f) - np.log(2.0)) * np.ones_like(motion.A))
    return Part(stiffness=motion.f**size * np.ones_like(motion.A))


def _drift(motion: Motion, rough: bool, size: float, shape: Shape) -> Array:
    """Give a factor that drifts with load cycles; rough: with their logarithm."""
    size = size * np.copysign(1.0, shape["sign"] - 0.4)
    seen = motion.cycles_seen / shape["cycles"]
    return 1 + size * (np.log1p(3 * seen) / np.log(4.0) if rough else -np.expm1(-seen))


def loosening(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stiffness that drifts with load cycles; rough: with their logarithm."""
    return Part(stiffness=_drift(motion, rough, size, shape))


def fade(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Damping that drifts with load cycles; rough: with their logarithm."""
    return Part(damping=_drift(motion, rough, size, shape))


def density(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stiffness and damping follow the density; rough: a straight line and a square."""
    ratio = motion.rho / 2.286
    if rough:
        return Part(stiffness=1 + size * 2.4 * (ratio - 1), damping=1 + size * shape["ratio"] * (ratio**2 - 1))
    return Part(stiffness=ratio ** (2 * size), damping=ratio ** (2 * size * shape["ratio"]))


def condition(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stiffness and damping follow a further column; rough: levelling off."""
    u = motion.u / 10.0
    if rough:
        level = u / (u + 1.0)
        return Part(stiffness=1 + size * level, damping=1 + size * shape["ratio"] * level)
    return Part(stiffness=np.exp(size * (u - 0.2 * shape["any"] * u**2)), damping=np.exp(size * shape["ratio"] * u))


def offset(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Constant force; rough: with a scatter of its own from run to run."""
    F_o = size * typical(base) * np.copysign(1.0, shape["sign"])
    level = F_o * (1 + (0.05 * motion.random[:, 2:3] if rough else 0.0))
    return Part(channel=lambda _, force: force + level)


def inertia(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Moving mass; rough: on a fixture that gives a little, so that fast tones see more of it."""
    mass = size * base.k10 / (2 * np.pi * 5.0) ** 2
    if not rough:
        return Part(channel=lambda _, force: force + mass * motion.a)
    acceleration = np.zeros_like(motion.a)
    for order, tone in motion.tones:
        w = 2 * np.pi * order * motion.f
        rotation = np.exp(1j * w * motion.time)
        acceleration -= np.real(tone[:, None] * rotation) * w**2 / (1 - (order * motion.f / 40.0) ** 2)
    return Part(channel=lambda _, force: force + mass * acceleration)


def delay(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Force channel late; rough: by a delay and a first-order lag."""
    tau = size * 0.01
    if rough:
        return Part(channel=lambda m, force: first_order(m, late(m, force, 0.7 * tau), 0.3 * tau))
    return Part(channel=lambda m, force: late(m, force, tau))


EFFECTS: dict[str, Kind] = {
    "memory": Kind(memory, most=0.8, rough_is="slip_spread"),
    "directional_slip": Kind(directional_slip, most=0.8),
    "slip_spread": Kind(slip_spread, most=0.8),
    "bouc_wen": Kind(bouc_wen_pinched, most=0.8),
    "coulomb": Kind(coulomb, most=0.15, rough_is="rounded_friction"),
    "viscous": Kind(viscous, most=0.15),
    "quadratic_damping": Kind(quadratic_damping, most=0.08),
    "directional_damping": Kind(directional_damping, most=0.6),
    "asymmetry": Kind(asymmetry),
    "hardening": Kind(hardening),
    "end_stop": Kind(end_stop, most=3.0),
    "unilateral_contact": Kind(unilateral_contact, most=3.0),
    "gap": Kind(gap, most=0.12),
    "play": Kind(play, most=0.12),
    "relaxation": Kind(relaxation, most=0.8, rough_is="relaxation_spread"),
    "damping_temperature": Kind(damping_temperature, start=0.05),
    "contact_growth": Kind(contact_growth),
    "stiffness_frequency": Kind(stiffness_frequency, most=0.3),
    "loosening": Kind(loosening, most=0.4, needs="cycles"),
    "fade": Kind(fade, start=0.05, needs="cycles"),
    "density": Kind(density, most=1.5, needs="density"),
    "condition": Kind(condition, needs="condition"),
    "offset": Kind(offset, most=0.2),
    "inertia": Kind(inertia),
    "delay": Kind(delay, most=1.0),
    "relaxation_spread": Kind(relaxation_spread, most=0.8),
    "oil_damper": Kind(oil_damper, most=0.3),
    "inner_mass": Kind(inner_mass, most=0.5),
    "stribeck": Kind(stribeck, most=0.3),
    "displacement_friction": Kind(displacement_friction, most=0.3),
    "pressed_slip": Kind(pressed_slip, most=0.3),
    "self_centring": Kind(self_centring, most=0.8),
    "exponential_stiffening": Kind(exponential_stiffening, most=1.0),
    "gas_spring": Kind(gas_spring, most=3.0),
    "rounded_friction": Kind(rounded_friction, most=0.3),
}
COLUMN = "bolt_torque_Nm"
"""The further column of runs.csv where the condition is studied."""


def effect_id(kind: str) -> str:
    """Give the id that a diagnosis names this kind by."""
    return f"condition:{COLUMN}" if kind == "condition" else kind


def draw_shape(random: np.random.Generator, amplitudes: tuple[float, ...], T: tuple[float, ...]) -> dict[str, float]:
    """Draw what an effect has besides its size.

    Args:
        random: generator.
        amplitudes: of the design, mm.
        T: temperatures of the design, degC.
    """
    largest = max(amplitudes)
    return {
        "limit": largest * random.uniform(0.08, 0.3),
        "several": random.uniform(),
        "speed": random.uniform(0.5, 2.0),
        "any": random.uniform(),
        "sign": random.uniform(-1.0, 1.0),
        "stop": largest * random.uniform(0.55, 0.85),
        "tau": float(np.exp(random.uniform(np.log(0.02), np.log(0.2)))),
        "contact": 273.15 + random.uniform(T[1] + 10.0, T[2] + 0.5 * (T[3] - T[2])),
        "cycles": random.uniform(40.0, 250.0),
        "ratio": random.uniform(0.4, 1.6),
        "place": random.uniform(0.3, 0.7),
        "delay": random.uniform(0.0, 2 * np.pi),
    }
