"""Which devices there are: law, source, test rigs it is put on, and which effects of the catalogue it really holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from devices import flow, hysteresis
from devices.drive import Array, Drive
from devices.hysteresis import Parameters

Draw = Callable[[np.random.Generator, float, float, float], dict[str, float]]


@dataclass(frozen=True)
class Device:
    """A law of a virtual device.

    Attributes:
        equation: in one line.
        source: in the literature.
        force: force in N, (n + 1, R), of a drive, from parameters.
        draw: parameters from a generator, largest displacement mm, order of the force N and circular frequency rad/s.
        rigs: names of the rigs it is put on, in turn.
        effects: ids of the effects that are its physics, whether the catalogue has them or not; none: physics that no
            effect is written for.
        run_in: cycles before the record begins, in which it settles; else the record begins with the ramp.
        steps: least steps a cycle.
        fastest: fastest rate of a state, 1/s, from the parameters.
    """

    equation: str
    source: str
    force: Callable[[Drive, Parameters], Array]
    draw: Draw
    rigs: tuple[str, ...]
    effects: frozenset[str] = frozenset()
    run_in: int = 0
    steps: int = 1000
    fastest: Callable[[Parameters], float] = lambda p: 0.0


def _fastest_oil(p: Parameters) -> float:
    return p["k"] / p["c2"]


def _fastest_rubber(p: Parameters) -> float:
    """At 50 degC, the hottest that it is tested at."""
    return 10 ** (p["C1"] * 30 / (p["C2"] + 30)) / p["tau"]


DEVICES: dict[str, Device] = {
    "bouc_wen": Device(
        "F = a k y + (1 - a) k z, dz = dy - (b |dy| sgn z + g dy) |z/D|^n",
        "Wen 1976, J. Eng. Mech. Div. 102(2)",
        hysteresis.bouc_wen, hysteresis.draw_bouc_wen, ("clamp", "damper", "bench"),
        frozenset({"memory", "bouc_wen", "slip_temperature"}),
    ),
    "dahl": Device(
        "F = k y + F_c z/D, dz = dy |1 - sgn(v) z/D|^i",
        "Dahl 1968, Aerospace Corp. TOR-0158(3107-18)-1",
        hysteresis.dahl, hysteresis.draw_dahl, ("mount", "bench", "clamp"), frozenset({"memory", "coulomb"}),
    ),
    "iwan": Device(
        "F = k y + k_T sum of elastic-slip elements, limits spread as phi^chi up to macroslip",
        "Segalman 2005, J. Appl. Mech. 72(5)",
        hysteresis.iwan, hysteresis.draw_iwan, ("clamp", "mount", "bench"),
        frozenset({"memory", "slip_spread", "slip_temperature"}),
    ),
    "power_law": Device(
        "dF = k (dy - |dy| sgn(s) |s|^n), s = (F - B)/Y, B = a k (y - F/k)",
        "Ozdemir 1976, PhD thesis, University of California, Berkeley",
        hysteresis.power_law, hysteresis.draw_power_law, ("damper", "bench", "clamp"), frozenset({"memory"}),
    ),
    "friction_pendulum": Device(
        "F = W y/R + mu W sgn v, elastic before it slides",
        "Zayas, Low and Mahin 1990, Earthquake Spectra 6(2); constant mu",
        hysteresis.friction_pendulum, hysteresis.draw_friction_pendulum, ("damper", "bench"),
        frozenset({"memory", "coulomb"}),
    ),
    "sliding_bearing": Device(
        "F = W y/R + mu(v) W z, elastic before it slides, mu = f_max - (f_max - f_min) exp(-a |v|)",
        "Constantinou, Mokha and Reinhorn 1990, J. Struct. Eng. 116(2)",
        hysteresis.sliding_bearing, hysteresis.draw_sliding_bearing, ("damper", "bench"),
        frozenset({"memory", "slip_speed"}),
    ),
    "drag": Device(
        "F = k y (1 + k3 y^2 + k5 y^4) + c v + c2 v |v|",
        "Ruzicka and Derby 1971, Influence of Damping in Vibration Isolation, SVM-7",
        flow.drag, flow.draw_drag, ("mount", "damper", "bench"),
        frozenset({"hardening", "viscous", "quadratic_damping"}),
    ),
    "zener_slip": Device(
        "F = k y + Maxwell arm + one elastic-slip element",
        "Berg 1998, Vehicle System Dynamics 30(3-4), with one elastic-slip element for its friction",
        flow.zener_slip, flow.draw_zener_slip, ("mount", "bench"), frozenset({"relaxation", "memory"}),
    ),
    "loose_hanger": Device(
        "F = k (|y| - g)+ sgn y + k_s (|y| - y_s)+ sgn y + c v + F_c sgn v",
        "Shaw and Holmes 1983, J. Sound Vib. 90(1)",
        flow.loose_hanger, flow.draw_loose_hanger, ("clamp", "damper", "bench"),
        frozenset({"gap", "end_stop", "viscous", "coulomb", "rounded_friction"}),
    ),
    "baber_noori": Device(
        "F = a k y + (1 - a) k z, dz = h(z)/eta (dy - nu (b |dy| sgn z + g dy) |z/D|^n), by dissipated energy",
        "Baber and Noori 1986, J. Vib. Acoust. 108(4); Foliente 1995, J. Struct. Eng. 121(6)",
        hysteresis.baber_noori, hysteresis.draw_baber_noori, ("damper", "bench"),
    ),
    "slip_lock": Device(
        "dy = dz/g(z) + f(z) dz: Bouc-Wen in series with a slip-lock element",
        "Baber and Noori 1985, J. Eng. Mech. 111(8)",
        hysteresis.slip_lock, hysteresis.draw_slip_lock, ("damper", "clamp", "bench"),
    ),
    "play_and_slip": Device(
        "play g in series with k_p x + k_s z, |z| <= z_s",
        "Tao and Kokotovic 1996, Adaptive Control of Systems with Actuator and Sensor Nonlinearities; Jenkins 1962",
        hysteresis.play_and_slip, hysteresis.draw_play_and_slip, ("clamp", "damper", "bench"),
        frozenset({"play", "memory"}), steps=8000,
    ),
    "relief_damper": Device(
        "dF/dt = k (v - v_valve(F)), valve c1 up to F_r and c2 beyond",
        "Kasai and Nishimura 2004, J. Struct. Constr. Eng. AIJ 69(583)",
        flow.relief_damper, flow.draw_relief_damper, ("damper", "bench"),
        frozenset({"oil_damper", "coulomb", "rounded_friction", "damping_temperature"}), fastest=_fastest_oil,
    ),
    "rubber": Device(
        "F = k y (1 + ..) + sum of Maxwell arms tau_i^-order, which flow faster by recent motion",
        "Koeller 1984, J. Appl. Mech. 51(2); Hoefer and Lion 2009, J. Mech. Phys. Solids 57(3)",
        flow.rubber, flow.draw_rubber, ("mount", "bench"), run_in=12,
    ),
    "warm_rubber": Device(
        "F = T/T0 (k y + sum of Maxwell arms, tau a_T), log10 a_T = -C1 (T - T0)/(C2 + T - T0)",
        "Williams, Landel and Ferry 1955, J. Am. Chem. Soc. 77(14)",
        flow.warm_rubber, flow.draw_warm_rubber, ("bench",),
        frozenset({"relaxation", "relaxation_spread", "relaxation_temperature", "damping_temperature"}), run_in=6,
        fastest=_fastest_rubber,
    ),
    "mr_damper": Device(
        "F = c1 dx/dt + k1 y, (c0 + c1) dx/dt = alpha z + c0 v + k0 (y - x), dz as Bouc-Wen of y - x; by current",
        "Spencer, Dyke, Sain and Carlson 1997, J. Eng. Mech. 123(3)",
        flow.mr_damper, flow.draw_mr_damper, ("controlled bench", "controlled damper"),
    ),
    "memory_alloy": Device(
        "dF = E (dy - |dy| |s|^(n-1) s), s = (F - B)/Y, B lifted on unloading",
        "Graesser and Cozzarelli 1991, J. Eng. Mech. 117(11)",
        hysteresis.memory_alloy, hysteresis.draw_memory_alloy, ("bench", "damper"),
    ),
    "wire_rope": Device(
        "F = k1 y (1 + k2 y + k3 y^2) + envelope(y) z/D, z of Bouc-Wen",
        "Ni, Ko, Wong and Zhan 1999, Proc. Inst. Mech. Eng. I 213(3)",
        hysteresis.wire_rope, hysteresis.draw_wire_rope, ("mount", "clamp", "bench"),
    ),
    "lugre": Device(
        "F = k y + s0 z + s1 dz/dt + s2 v, dz/dt = v - s0 |v| z/g(v), g falling with |v|",
        "Canudas de Wit, Olsson, Astroem and Lischinsky 1995, IEEE Trans. Autom. Control 40(3)",
        hysteresis.lugre, hysteresis.draw_lugre, ("bench", "mount", "damper"),
    ),
    "ring_spring": Device(
        "F = k y (1 + mu sgn(y v)): friction that grows with the displacement",
        "Hill 1995, PhD thesis, University of Canterbury: ring springs as dampers in buildings",
        hysteresis.ring_spring, hysteresis.draw_ring_spring, ("bench", "damper"),
        frozenset({"pressed_slip", "displacement_friction"}),
    ),
    "eddy_current": Device(
        "F = k y + 2 F_m (v/v_c) / (1 + (v/v_c)^2)",
        "Wouterse 1991, IEE Proc. B 138(4)",
        flow.eddy_current, flow.draw_eddy_current, ("damper", "mount", "bench"),
    ),
    "air_spring": Device(
        "F = S (p1 - p0), polytropic in two volumes, flow between them as sqrt(p1 - p2)",
        "Quaglia and Sorli 2001, Vehicle System Dynamics 35(6)",
        flow.air_spring, flow.draw_air_spring, ("damper", "bench"),
    ),
    "hydraulic_mount": Device(
        "F = k_r y + c_r v + K(y - x), m x'' = K(y - x) - losses; decoupler with play",
        "Singh, Kim and Ravindra 1992, J. Sound Vib. 158(2)",
        flow.hydraulic_mount, flow.draw_hydraulic_mount, ("mount",), run_in=12,
    ),
}  # fmt: skip
"""By name."""
