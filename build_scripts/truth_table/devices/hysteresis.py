"""Devices whose loops don't depend on speed, or hardly: dry friction, yielding metal, ropes, memory alloys.

Each function gives the force in N, (n + 1, R), of a drive, from parameters in mm, s, N. Each `draw_` function draws the
parameters for a device that sees displacements up to `x` mm and forces of the order of `F` N at `w` rad/s.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.special import erf

from devices.drive import Array, Drive, march, slipping

Parameters = Mapping[str, float]


def softened(drive: Drive, per_100_K: float) -> Array:
    """Give the factor of a modulus that falls linearly with temperature, one at 20 degC, (R,)."""
    return 1 - per_100_K * (drive.T - 20) / 100


def _bouc_wen(drive: Drive, p: Parameters) -> Array:
    """Hysteretic displacement z of Bouc and Wen, mm, (n + 1, R), bounded by D."""
    D, n, beta = p["D"], p["n"], p["beta"]

    def rates(i: int, z: Array) -> Array:
        v = drive.v[i]
        level = np.abs(z / D) ** n
        return v - (beta * np.abs(v) * np.sign(z) + (1 - beta) * v) * level

    return march(rates, np.zeros((1, drive.runs)), drive)[:, 0]


def bouc_wen(drive: Drive, p: Parameters) -> Array:
    """Spring beside a Bouc-Wen element."""
    y, _, _ = drive.whole
    modulus = softened(drive, p["softening"])
    return modulus * p["k"] * (p["alpha"] * y + (1 - p["alpha"]) * _bouc_wen(drive, p))


def draw_bouc_wen(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Yields at 5 to 35 % of the largest displacement."""
    D = x * random.uniform(0.05, 0.35)
    alpha = random.uniform(0.05, 0.3)
    return {"D": D, "n": random.uniform(1.0, 2.0), "beta": random.uniform(0.5, 0.75), "alpha": alpha,
            "k": F / (alpha * x + (1 - alpha) * D), "softening": random.uniform(0.02, 0.06)}  # fmt: skip


def baber_noori(drive: Drive, p: Parameters) -> Array:
    """Bouc-Wen element that pinches and degrades with the energy it has dissipated, per unit of k D^2."""
    D, n, beta = p["D"], p["n"], p["beta"]
    y, _, _ = drive.whole

    def rates(i: int, states: Array) -> Array:
        z, energy = states
        v = drive.v[i]
        strength = 1 + p["d_nu"] * energy
        compliance = 1 + p["d_eta"] * energy
        most = D * strength ** (-1 / n)
        zeta = p["zeta"] * (1 - np.exp(-p["p"] * energy))
        width = (p["psi"] + p["d_psi"] * energy) * D
        pinching = 1 - zeta * np.exp(-(((z * np.sign(v) - p["q"] * most) / width) ** 2))
        level = strength * np.abs(z / D) ** n
        z_rate = pinching / compliance * (v - (beta * np.abs(v) * np.sign(z) + (1 - beta) * v) * level)
        return np.stack([z_rate, np.maximum(z * v, 0.0) / D**2 * 0.5])

    start = np.zeros((2, drive.runs))
    start[1] = p["energy"]
    z = march(rates, start, drive)[:, 0]
    return p["k"] * (p["alpha"] * y + (1 - p["alpha"]) * z)


def draw_baber_noori(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """A device that has been worked before, so that it degrades by some percent within a record."""
    D = x * random.uniform(0.1, 0.3)
    alpha = random.uniform(0.08, 0.25)
    return {"D": D, "n": random.uniform(1.0, 1.6), "beta": random.uniform(0.5, 0.75), "alpha": alpha,
            "k": F / (alpha * x + (1 - alpha) * D), "d_nu": random.uniform(5e-5, 2e-4),
            "d_eta": random.uniform(5e-5, 3e-4), "zeta": random.uniform(0.6, 0.9), "p": 0.05,
            "psi": random.uniform(0.2, 0.35), "d_psi": 1e-4, "q": random.uniform(0.05, 0.2),
            "energy": 100.0}  # fmt: skip


def slip_lock(drive: Drive, p: Parameters) -> Array:
    """Bouc-Wen element in series with a slip-lock element that gives way while the force is small."""
    D, n, beta, alpha = p["D"], p["n"], p["beta"], p["alpha"]
    y, _, _ = drive.whole

    def rates(i: int, z: Array) -> Array:
        v = drive.v[i]
        slope = 1 - np.abs(z / D) ** n * (beta * np.sign(v * z) + (1 - beta))
        give = np.sqrt(2 / np.pi) * p["slip"] / p["sigma"] * np.exp(-((z / p["sigma"]) ** 2) / 2)
        return v * slope / (1 + give * slope)

    z = march(rates, np.zeros((1, drive.runs)), drive)[:, 0]
    return p["k"] * (alpha * y + (1 - alpha) * z)


def draw_slip_lock(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Slips by 20 to 50 % of the largest displacement."""
    D = x * random.uniform(0.08, 0.25)
    alpha = random.uniform(0.03, 0.12)
    return {"D": D, "n": random.uniform(1.0, 2.0), "beta": random.uniform(0.5, 0.7), "alpha": alpha,
            "k": F / (alpha * x + (1 - alpha) * D), "slip": x * random.uniform(0.2, 0.5),
            "sigma": D * random.uniform(0.1, 0.25)}  # fmt: skip


def play_and_slip(drive: Drive, p: Parameters) -> Array:
    """Clearance in series with a spring beside an elastic-slip element; grease damps the clearance a little."""
    y, v, _ = drive.whole
    force = np.zeros_like(y)
    x = np.zeros(drive.runs)
    z = np.zeros(drive.runs)
    stiff = p["k_p"] + p["k_s"]
    for number, place in enumerate(y):
        free = x - force[number - 1] / stiff if number else x  # where the moved part goes when nothing touches it
        new = np.minimum(np.maximum(free, place - p["g"]), place + p["g"])
        z = np.minimum(np.maximum(z + new - x, -p["limit"]), p["limit"])
        x = new
        force[number] = p["k_p"] * x + p["k_s"] * z
    return force + p["c"] * v


def draw_play_and_slip(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Free play of 10 to 40 % of the largest displacement; slip from half its stroke on at most."""
    g = x * random.uniform(0.05, 0.2)
    limit = (x - g) * random.uniform(0.08, 0.3)
    friction = random.uniform(0.3, 0.6)
    return {"g": g, "limit": limit, "k_s": friction * F / limit, "k_p": (1 - friction) * F / (x - g),
            "c": random.uniform(0.001, 0.003) * F / (w * x)}  # fmt: skip


def memory_alloy(drive: Drive, p: Parameters) -> Array:
    """Superelastic shape-memory alloy of Graesser and Cozzarelli: flag-shaped loops, no set left behind."""
    E, Y, n = p["E"], p["Y"], p["n"]
    plateau = Y * (1 + p["per_K"] * (drive.T - 20) / 100)

    def rates(i: int, force: Array) -> Array:
        here, v = drive.y[i], drive.v[i]
        unloading = here * v < 0
        lift = p["f"] * np.abs(here) ** p["c"] * erf(p["a"] * here) * unloading
        back = E * p["alpha"] * (here - force / E + lift)
        over = (force - back) / plateau
        return E * (v - np.abs(v) * np.abs(over) ** (n - 1) * over)

    return march(rates, np.zeros((1, drive.runs)), drive)[:, 0]


def draw_memory_alloy(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Transforms from 15 to 35 % of the largest displacement on."""
    Y = F * random.uniform(0.5, 0.75)
    bend = x * random.uniform(0.12, 0.25)
    E = Y / bend
    alpha = random.uniform(0.05, 0.15)
    c = random.uniform(0.001, 0.05)
    # unloading is lifted by up to three quarters of the loop's height, so that nothing or little is left behind
    f = random.uniform(1.0, 1.5) * Y / (E * alpha) / x**c
    return {"E": E, "Y": Y, "alpha": alpha, "n": random.uniform(2.0, 5.0), "f": f, "c": c,
            "a": random.uniform(2.0, 5.0) / x, "per_K": random.uniform(0.2, 0.6)}  # fmt: skip


def wire_rope(drive: Drive, p: Parameters) -> Array:
    """Wire rope isolator: an asymmetric, stiffening envelope around a Bouc-Wen variable."""
    y, _, _ = drive.whole
    s = y / p["x"]
    elastic = p["k1"] * y * (1 + p["k2"] * s + p["k3"] * s**2)
    envelope = p["F"] * np.exp(p["b"] * s) * (1 + p["e"] * s**2)
    return softened(drive, p["softening"]) * (elastic + envelope * _bouc_wen(drive, p) / p["D"])


def draw_wire_rope(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Softer in tension than in compression, friction of a fifth to half of the force."""
    D = x * random.uniform(0.08, 0.25)
    friction = random.uniform(0.2, 0.45)
    return {"x": x, "D": D, "n": random.uniform(1.0, 1.6), "beta": random.uniform(0.5, 0.7), "F": friction * F,
            "k1": (1 - friction) * F / x, "k2": random.uniform(-0.4, -0.15), "k3": random.uniform(0.15, 0.5),
            "b": random.uniform(0.15, 0.5), "e": random.uniform(0.1, 0.5),
            "softening": random.uniform(0.01, 0.05)}  # fmt: skip


def dahl(drive: Drive, p: Parameters) -> Array:
    """Dahl friction of any exponent beside a spring."""
    D = p["D"]
    y, _, _ = drive.whole

    def rates(i: int, z: Array) -> Array:
        v = drive.v[i]
        room = 1 - z * np.sign(v) / D
        return v * np.sign(room) * np.abs(room) ** p["i"]

    z = march(rates, np.zeros((1, drive.runs)), drive)[:, 0]
    return p["k"] * y + p["F"] * z / D


def draw_dahl(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Friction of 30 to 60 % of the force."""
    friction = random.uniform(0.3, 0.6)
    return {"D": x * random.uniform(0.08, 0.3), "i": random.uniform(0.8, 1.6), "F": friction * F,
            "k": (1 - friction) * F / x}  # fmt: skip


def lugre(drive: Drive, p: Parameters) -> Array:
    """LuGre friction, whose slip force falls with speed (Stribeck), beside a spring."""
    y, v, _ = drive.whole

    def most(speed: Array) -> Array:
        return p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((speed / p["v_s"]) ** 2))

    def rates(i: int, z: Array) -> Array:
        speed = drive.v[i]
        return speed - p["s0"] * np.abs(speed) * z / most(speed)

    z = march(rates, np.zeros((1, drive.runs)), drive)[:, 0]
    z_rate = v - p["s0"] * np.abs(v) * z / most(v)
    return p["k"] * y + p["s0"] * z + p["s1"] * z_rate + p["s2"] * v


def draw_lugre(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Friction that halves at most over the range of speeds."""
    F_c = F * random.uniform(0.25, 0.5)
    F_s = F_c * random.uniform(1.3, 2.0)
    bristle = x * random.uniform(0.02, 0.06)
    return {"F_c": F_c, "F_s": F_s, "v_s": w * x * random.uniform(0.1, 0.4), "s0": F_s / bristle,
            "s1": 0.05 * F / (w * x), "s2": random.uniform(0.02, 0.1) * F / (w * x),
            "k": F * random.uniform(0.3, 0.6) / x}  # fmt: skip


def iwan(drive: Drive, p: Parameters) -> Array:
    """Segalman's four-parameter Iwan joint: slip forces spread by a power law up to a macroslip."""
    y, _, _ = drive.whole
    edges = np.linspace(0.0, 1.0, ELEMENTS + 1) ** 2
    limits = p["phi"] * (edges[1:] + edges[:-1]) / 2
    density = np.diff(edges ** (p["chi"] + 1))  # stiffness that lets go within each interval
    share = np.concatenate([density / (1 + p["beta"]), [p["beta"] / (1 + p["beta"])]])
    stretch = slipping(y, np.concatenate([limits, [p["phi"]]])[:, None])
    return softened(drive, p["softening"]) * (p["k_T"] * np.einsum("ner,e->nr", stretch, share) + p["k"] * y)


ELEMENTS = 80
"""Elements that stand for the spread of slip forces."""


def draw_iwan(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Slips as a whole near the largest displacement."""
    residual = random.uniform(0.1, 0.3)
    phi = x * random.uniform(0.5, 1.2)
    return {"phi": phi, "chi": random.uniform(-0.7, -0.1), "beta": random.uniform(0.05, 0.5),
            "k_T": 2 * (1 - residual) * F / phi, "k": residual * F / x,
            "softening": random.uniform(0.02, 0.06)}  # fmt: skip


def friction_pendulum(drive: Drive, p: Parameters) -> Array:
    """Sliding on a dish: the weight's restoring force and dry friction, which sticks elastically at first."""
    y, _, _ = drive.whole
    stretch = slipping(y, np.array([[p["limit"]]]))[:, 0]
    return p["W"] * (y / p["radius"] + p["mu"] * stretch / p["limit"])


def draw_friction_pendulum(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Friction coefficient of 4 to 12 %."""
    mu = random.uniform(0.04, 0.12)
    radius = x / (mu * random.uniform(0.5, 2.0))
    return {"mu": mu, "radius": radius, "W": F / (mu + x / radius), "limit": x * random.uniform(0.01, 0.04)}


def sliding_bearing(drive: Drive, p: Parameters) -> Array:
    """Teflon on steel on a dish: friction that grows with the sliding speed."""
    y, v, _ = drive.whole
    stretch = slipping(y, np.array([[p["limit"]]]))[:, 0]
    mu = p["mu"] * (1 - (1 - p["slow"]) * np.exp(-np.abs(v) / p["v_a"]))
    return p["W"] * (y / p["radius"] + mu * stretch / p["limit"])


def draw_sliding_bearing(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Friction next to rest 20 to 60 % of that at speed."""
    values = draw_friction_pendulum(random, x, F, w)
    return {**values, "slow": random.uniform(0.2, 0.6), "v_a": random.uniform(0.1, 0.4) * x * w}


def ring_spring(drive: Drive, p: Parameters) -> Array:
    """Stack of rings with conical faces: elastic force with friction in proportion to it, which sticks at first."""
    y, _, _ = drive.whole
    stretch = slipping(y, np.array([[p["limit"]]]))[:, 0]
    return p["k"] * (y + p["mu"] * np.abs(y) * stretch / p["limit"])


def draw_ring_spring(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Unloads at 30 to 60 % of the force at which it was loaded."""
    mu = random.uniform(0.25, 0.55)
    return {"mu": mu, "k": F / (x * (1 + mu)), "limit": x * random.uniform(0.01, 0.04)}


def power_law(drive: Drive, p: Parameters) -> Array:
    """Hysteretic power law of Ozdemir: rounded yielding about a moving back force."""
    k, Y, n = p["k"], p["Y"], p["n"]

    def rates(i: int, force: Array) -> Array:
        v = drive.v[i]
        over = (force - p["alpha"] * k * (drive.y[i] - force / k)) / Y
        return k * (v - np.abs(v) * np.sign(over) * np.abs(over) ** n)

    return march(rates, np.zeros((1, drive.runs)), drive)[:, 0]


def draw_power_law(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Yields at 10 to 35 % of the largest displacement."""
    bend = x * random.uniform(0.1, 0.35)
    alpha = random.uniform(0.05, 0.2)
    Y = F / (1 + alpha * (x / bend - 1))
    return {"k": Y / bend, "Y": Y, "n": random.uniform(1.0, 5.0), "alpha": alpha}
