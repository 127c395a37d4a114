"""Devices in which something flows, relaxes or strikes: oil, gas, rubber, magnetic fluid, loose hangers.

Functions as in `hysteresis`.
"""

from __future__ import annotations

import numpy as np

from devices.drive import Array, Drive, march, slipping
from devices.hysteresis import Parameters


def relief_damper(drive: Drive, p: Parameters) -> Array:
    """Oil damper: valves that open further at a relief force, behind a compressible column of oil; seals rub."""
    y, v, _ = drive.whole
    thin = np.exp(-p["thinning"] * (drive.T - 20) / 100)
    relief = p["F_r"]

    def rates(i: int, force: Array) -> Array:
        passed = np.clip(force, -relief, relief)
        speed = passed / (p["c1"] * thin) + (force - passed) / (p["c2"] * thin)
        return p["k"] * (drive.v[i] - speed)

    oil = march(rates, np.zeros((1, drive.runs)), drive)[:, 0]
    return oil + p["k_g"] * y + p["F_seal"] * np.tanh(v / p["v_seal"])


def draw_relief_damper(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Relief at 40 to 80 % of the force; the oil gives by 3 to 10 % of the largest displacement."""
    F_r = F * random.uniform(0.4, 0.8)
    c1 = F_r / (w * x * random.uniform(0.3, 0.8))
    return {"F_r": F_r, "c1": c1, "c2": c1 * random.uniform(0.12, 0.3), "k": F / (x * random.uniform(0.03, 0.1)),
            "k_g": F * random.uniform(0.02, 0.1) / x, "F_seal": F * random.uniform(0.01, 0.03), "v_seal": 0.02 * w * x,
            "thinning": random.uniform(0.2, 0.6)}  # fmt: skip


def rubber(drive: Drive, p: Parameters) -> Array:
    """Filled rubber: Maxwell arms, near to a springpot, that flow faster the more it moved lately (Payne)."""
    y, _, _ = drive.whole
    tau = p["tau"] * np.geomspace(1.0, p["span"], ARMS)[:, None]
    k = p["k_arms"] * tau ** -p["order"] / np.sum(tau ** -p["order"])
    hard = np.exp(-p["per_100_K"] * (drive.T - 20) / 100)

    def rates(i: int, states: Array) -> Array:
        v = drive.v[i]
        moved = states[-1]
        flow = (1 + moved / p["v_payne"]) / (tau * hard)
        return np.concatenate([k * v - states[:-1] * flow, [(np.abs(v) - moved) / p["heal"]]])

    arms = march(rates, np.zeros((ARMS + 1, drive.runs)), drive)[:, :-1].sum(axis=1)
    return np.sqrt(hard) * (p["k"] * y * (1 + p["k3"] * (y / p["x"]) ** 2) + arms)


ARMS = 8


def draw_rubber(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Arms relax over nearly two decades about the motion's period."""
    arms = random.uniform(0.6, 1.5)
    k = F / x / (1 + 0.4 * arms)
    return {"k": k, "k_arms": arms * k, "tau": 0.1 / w, "span": 60.0, "order": random.uniform(0.2, 0.5),
            "v_payne": w * x * random.uniform(0.05, 0.3), "heal": 5.0 / w, "k3": random.uniform(0.0, 0.2), "x": x,
            "per_100_K": random.uniform(0.3, 1.0)}  # fmt: skip


def warm_rubber(drive: Drive, p: Parameters) -> Array:
    """Unfilled rubber: Maxwell arms whose times shift by Williams, Landel and Ferry; stiffness as the temperature."""
    y, _, _ = drive.whole
    tau = p["tau"] * np.geomspace(1.0, p["span"], ARMS)[:, None]
    k = p["k_arms"] * tau ** -p["order"] / np.sum(tau ** -p["order"])
    shifted = tau * 10 ** (-p["C1"] * (drive.T - 20) / (p["C2"] + drive.T - 20))

    def rates(i: int, states: Array) -> Array:
        return k * drive.v[i] - states / shifted

    arms = march(rates, np.zeros((ARMS, drive.runs)), drive).sum(axis=1)
    return (drive.T + 273.15) / 293.15 * (p["k"] * y + arms)


def draw_warm_rubber(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Arms relax over four decades about the motion's period at 20 degC."""
    arms = random.uniform(0.8, 2.0)
    k = F / x / (1 + 0.4 * arms)
    return {"k": k, "k_arms": arms * k, "tau": 0.01 / w, "span": 1e4, "order": random.uniform(0.05, 0.2),
            "C1": random.uniform(3.0, 6.0), "C2": random.uniform(120.0, 160.0)}  # fmt: skip


def mr_damper(drive: Drive, p: Parameters) -> Array:
    """Magnetorheological damper of Spencer (modified Bouc-Wen); its coefficients rise with current and saturate."""
    y, v, _ = drive.whole
    field = np.tanh(drive.u / p["u_s"]) / np.tanh(1 / p["u_s"])
    alpha = p["alpha_0"] + p["alpha_u"] * field
    c0 = p["c0"] * (1 + p["c_u"] * field)
    c1 = p["c1"] * (1 + 2 * p["c_u"] * field)
    D = p["D"]

    def inner(i: int, z: Array, x: Array) -> Array:
        return (alpha * z / D + c0 * drive.v[i] + p["k0"] * (drive.y[i] - x)) / (c0 + c1)

    def rates(i: int, states: Array) -> Array:
        z, x = states
        x_rate = inner(i, z, x)
        v = drive.v[i] - x_rate
        z_rate = v - (p["beta"] * np.abs(v) * np.sign(z) + (1 - p["beta"]) * v) * np.abs(z / D) ** 2
        return np.stack([z_rate, x_rate])

    states = march(rates, np.zeros((2, drive.runs)), drive)
    z, x = states[:, 0], states[:, 1]
    return c1 * (alpha * z / D + c0 * v + p["k0"] * (y - x)) / (c0 + c1) + p["k1"] * y


def draw_mr_damper(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Its force rises three- to eightfold with the current."""
    alpha_u = F * random.uniform(0.6, 0.8)
    c0 = F * random.uniform(0.05, 0.15) / (w * x)
    return {"alpha_0": alpha_u / random.uniform(3.0, 8.0), "alpha_u": alpha_u, "u_s": random.uniform(0.6, 1.2),
            "c0": c0, "c_u": random.uniform(0.5, 2.0), "c1": c0 * random.uniform(15, 40),
            "D": x * random.uniform(0.03, 0.1), "beta": random.uniform(0.5, 0.8),
            "k0": F * random.uniform(0.01, 0.05) / x, "k1": F * random.uniform(0.01, 0.05) / x}  # fmt: skip


def air_spring(drive: Drive, p: Parameters) -> Array:
    """Air spring with a second volume behind an orifice: polytropic in both, flow as the root of the difference."""
    y, v, _ = drive.whole
    n, ratio = p["n"], p["ratio"]

    def pressures(place: Array, moved: Array) -> tuple[Array, Array]:
        return ((1 - moved) / (1 - place / p["L"])) ** n, (1 + moved / ratio) ** n

    def rates(i: int, moved: Array) -> Array:
        first, second = pressures(drive.y[i], moved)
        ahead = first - second
        return p["C"] * ahead / np.sqrt(np.abs(ahead) + p["laminar"])

    moved = march(rates, np.zeros((1, drive.runs)), drive)[:, 0]
    return p["S"] * (pressures(y, moved)[0] - 1) + p["F_rub"] * np.tanh(v / p["v_rub"])


def draw_air_spring(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Compressed by up to 25 to 40 % of its column."""
    L = x / random.uniform(0.25, 0.4)
    n = random.uniform(1.2, 1.4)
    S = F / (((1 - x / L) ** -n) - 1) * 1.3
    return {"L": L, "n": n, "ratio": random.uniform(0.5, 2.0), "S": S, "C": w * x / L * random.uniform(0.5, 2.0),
            "laminar": 0.01, "F_rub": F * random.uniform(0.01, 0.04), "v_rub": 0.03 * w * x}  # fmt: skip


def hydraulic_mount(drive: Drive, p: Parameters) -> Array:
    """Rubber mount with an inertia track: fluid that resonates on the bulge of its chamber; a decoupler with play."""
    y, v, _ = drive.whole
    turn = 2 * np.pi * p["f0"]

    def bulge(behind: Array) -> Array:
        return p["k_b"] * (behind - p["loose"] * np.clip(behind, -p["play"], p["play"]))

    def rates(i: int, states: Array) -> Array:
        x, speed = states
        pushed = bulge(drive.y[i] - x) / p["m"]
        lost = 2 * p["zeta"] * turn * speed + p["turbulent"] * np.abs(speed) * speed
        return np.stack([speed, pushed - lost])

    x = march(rates, np.zeros((2, drive.runs)), drive)[:, 0]
    return p["k_r"] * y + p["c_r"] * v + bulge(y - x)


def draw_hydraulic_mount(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Resonates inside the range of the frequencies."""
    f0 = w / (2 * np.pi) * random.uniform(0.8, 1.4)
    k_b = F / x * random.uniform(0.4, 1.0)
    return {"k_r": F / x * 0.6, "c_r": 0.03 * F / (w * x), "k_b": k_b, "m": k_b / (2 * np.pi * f0) ** 2, "f0": f0,
            "zeta": random.uniform(0.15, 0.4), "turbulent": random.uniform(0.1, 0.5) / x,
            "loose": random.uniform(0.6, 0.95), "play": x * random.uniform(0.03, 0.15)}  # fmt: skip


def drag(drive: Drive, p: Parameters) -> Array:
    """Polynomial spring with viscous and quadratic drag."""
    y, v, _ = drive.whole
    s = y / p["x"]
    return p["k"] * y * (1 + p["k3"] * s**2 + p["k5"] * s**4) + p["c"] * v + p["c2"] * v * np.abs(v)


def draw_drag(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Stiffens by about two at the largest displacement."""
    k3, k5 = random.uniform(-0.3, 0.6), random.uniform(0.2, 0.8)
    return {"x": x, "k": 0.8 * F / x / (1 + k3 + k5), "k3": k3, "k5": k5, "c": F * random.uniform(0.03, 0.15) / (w * x),
            "c2": F * random.uniform(0.03, 0.15) / (w * x) ** 2}  # fmt: skip


def eddy_current(drive: Drive, p: Parameters) -> Array:
    """Eddy-current brake beside a spring: the force falls beyond a critical speed."""
    y, v, _ = drive.whole
    speed = v / p["v_c"]
    return p["k"] * y + 2 * p["F_m"] * speed / (1 + speed**2)


def draw_eddy_current(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Critical within the range of speeds."""
    friction = random.uniform(0.3, 0.6)
    return {"F_m": friction * F, "k": (1 - friction) * F / x, "v_c": w * x * random.uniform(0.4, 1.5)}


def zener_slip(drive: Drive, p: Parameters) -> Array:
    """Spring, Maxwell arm and elastic-slip element in parallel."""
    y, _, _ = drive.whole

    def rates(i: int, force: Array) -> Array:
        return p["k_m"] * drive.v[i] - force / p["tau"]

    arm = march(rates, np.zeros((1, drive.runs)), drive)[:, 0]
    return p["k"] * y + arm + p["F"] * slipping(y, np.array([[p["limit"]]]))[:, 0] / p["limit"]


def draw_zener_slip(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """The arm relaxes within the motion's period."""
    return {"k": 0.5 * F / x, "k_m": F * random.uniform(0.2, 0.6) / x, "tau": random.uniform(0.4, 2.0) / w,
            "F": F * random.uniform(0.1, 0.3), "limit": x * random.uniform(0.08, 0.3)}  # fmt: skip


def loose_hanger(drive: Drive, p: Parameters) -> Array:
    """Hanger with clearance about its middle, a stop, grease and guides that rub."""
    y, v, _ = drive.whole
    beyond = np.sign(y) * np.maximum(np.abs(y) - p["g"], 0.0)
    stop = np.sign(y) * np.maximum(np.abs(y) - p["stop"], 0.0)
    return p["k"] * beyond + p["k_stop"] * stop + p["c"] * v + p["F"] * np.tanh(v / p["v_r"])


def draw_loose_hanger(random: np.random.Generator, x: float, F: float, w: float) -> dict[str, float]:
    """Clearance of 10 to 30 % of the largest displacement, the stop at 60 to 80 %; friction is rounded, as it is."""
    g, stop = x * random.uniform(0.1, 0.3), x * random.uniform(0.6, 0.8)
    k = 0.6 * F / (x - g)
    return {"g": g, "stop": stop, "k": k, "k_stop": k * random.uniform(0.5, 2.0),
            "c": F * random.uniform(0.03, 0.1) / (w * x), "F": F * random.uniform(0.05, 0.15),
            "v_r": w * x * 10 ** random.uniform(-3.0, -2.0)}  # fmt: skip
