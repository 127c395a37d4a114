"""Which laws there are: equation, source, and as which family of terms each may be proposed."""

from __future__ import annotations

from dataclasses import dataclass

from hidden import Kind

from beyond import factors, plain, states

SPRING, DAMPER, ELEMENT, FACTOR = "spring", "damper", "element", "factor"
CLOSED = "in closed form; no one source"


@dataclass(frozen=True)
class Beyond:
    """A law that no catalogue has.

    Attributes:
        families: as what it may be proposed. Dry friction is a damper as much as an element that hardly gives.
        equation: in one line.
        source: in the literature.
        kind: what it does, and in which sizes.
    """

    families: frozenset[str]
    equation: str
    source: str
    kind: Kind


def _law(kind: Kind, equation: str, source: str, *families: str) -> Beyond:
    return Beyond(frozenset(families), equation, source, kind)


LAWS: dict[str, Beyond] = {
    "detents": _law(
        Kind(plain.detents), "F = F_s sin(x) / (1 + r^2 + 2 r cos(x))^2, x = 2 pi y/l, l < A",
        "Peyrard and Remoissenet 1982, Phys. Rev. B 26(6)", SPRING,
    ),
    "bimetal_stop": _law(
        Kind(plain.bimetal_stop, most=5.0), "F = k (|y| - g_0 (1 - s (1 + tanh((T - T_s)/w))))+^1.5 sgn(y)",
        "Hertz 1882, J. reine angew. Math. 92: a round contact; moved as a bimetal snaps, Timoshenko 1925, J. Opt. "
        "Soc. Am. 11(3)", SPRING,
    ),
    "bumpers": _law(
        Kind(plain.bumpers, most=5.0), "F = k (u/(1 - u/h) - w/(1 - w/h)), u = (y - a)+, w = (-y - 2 a)+", CLOSED,
        SPRING,
    ),
    "thickening_paste": _law(
        Kind(plain.thickening_paste, most=3.0), "F = c v (1 + b/(1 + exp(-(|v|/v_c - 1)/w)))",
        "after Galindo-Rosales, Rubio-Hernandez and Sevilla 2011, J. Non-Newton. Fluid Mech. 166(5-6): a viscosity "
        "between two, here by a step", DAMPER,
    ),
    "melting_wax": _law(
        Kind(plain.melting_wax), "F = F_y tanh(v/v_s) (1 - tanh((T - T_m)/w))/2 + c v",
        "Bingham 1922, Fluidity and Plasticity; its yield stress gone with melting, in closed form", DAMPER,
    ),
    "cavitating_film": _law(
        Kind(plain.cavitating_film), "F = max(c v / (1 - y/h)^3, -F_t)",
        "Reynolds 1886, Phil. Trans. R. Soc. 177; torn as in Dowson and Taylor 1979, Annu. Rev. Fluid Mech. 11", DAMPER,
    ),
    "barrel": _law(
        Kind(plain.barrel, most=3.0), "F = c v (1 + (y/y_s - 0.03)^4)/(1 + |v|/v_c)",
        "Cross 1965, J. Colloid Sci. 20(5), with an exponent of 1, through a bore that narrows", DAMPER,
    ),
    "jammed_paste": _law(
        Kind(plain.jammed_paste, most=1.5), "F = c v (1 + b x^2/(1 + x^4)), x = v/v_c",
        "after Brown and Jaeger 2014, Rep. Prog. Phys. 77(4): a viscosity that rises and falls again", DAMPER,
    ),
    "struck_pad": _law(
        Kind(plain.struck_pad, most=3.0), "F = k (y - d)+^2.5 (1 + b v |v|)+",
        "after Hunt and Crossley 1975, J. Appl. Mech. 42(2), with a square of the speed", SPRING, DAMPER,
    ),
    "shifted_flow": _law(
        Kind(plain.shifted_flow), "F = F_m tanh(v/v_s + b tanh(y/y_s))",
        "Kwok, Ha, Nguyen, Li and Samali 2006, Sens. Actuators A 132(2), their sgn(y) made smooth", DAMPER, ELEMENT,
    ),
    "gliding_arm": _law(
        Kind(states.gliding_arm), "dF/dt = k (v - v_g exp(-F_e/|F|) sgn(F))",
        "Johnston and Gilman 1959, J. Appl. Phys. 30(2): the speed of dislocations", ELEMENT, DAMPER,
    ),
    "viscoplastic": _law(
        Kind(states.viscoplastic), "dF/dt = k (v - v_p sgn(F) (|F|/F_y - 1)+)", "Perzyna 1966, Adv. Appl. Mech. 9",
        ELEMENT,
    ),
    "elastic_bristles": _law(
        Kind(states.elastic_bristles), "dz/dt = v (1 - a(z) |z|/g(v)), g = z_s (1 + b exp(-(v/v_s)^2)), a from 0 to 1",
        "Dupont, Hayward, Armstrong and Altpeter 2002, IEEE Trans. Autom. Control 47(5)", ELEMENT,
    ),
    "flag": _law(
        Kind(states.flag), "dF = k dy within [min(k |y|, F_r), min(k |y|, F_y)] sgn(y)",
        "Christopoulos, Filiatrault and Folz 2002, Earthquake Eng. Struct. Dyn. 31(5)", ELEMENT,
    ),
    "hardening_plastic": _law(
        Kind(states.hardening_plastic, most=2.0), "|F - X| <= F_y, dX = C dp - g X |dp|",
        "Armstrong and Frederick 1966, CEGB Report RD/B/N 731", ELEMENT,
    ),
    "wire_rope": _law(
        Kind(states.wire_rope), "F = F_c exp(y/y_c) z, dz = (sgn(v) - z) |dy|/x",
        "Ni, Ko, Wong and Zhan 1999, Proc. Inst. Mech. Eng. I 213(3)", ELEMENT, DAMPER,
    ),
    "setting_paste": _law(
        Kind(states.setting_paste), "F = c v (1 + q^1.5), dq/dt = 1/t - q |v|/x",
        "Coussot, Nguyen, Huynh and Bonn 2002, Phys. Rev. Lett. 88(17)", DAMPER, ELEMENT,
    ),
    "ageing_contacts": _law(
        Kind(states.ageing_contacts, most=1.0),
        "F = F_c (1 + a ln(|v|/v_0) + b ln(q v_0/x)) sgn(v), dq/dt = 1 - |v| q/x",
        "Ruina 1983, J. Geophys. Res. 88(B12)", DAMPER, ELEMENT,
    ),
    "warm_arm": _law(
        Kind(states.warm_arm, most=1.0), "dF/dt = k v - F/t(T), t = t_0 exp(B (1/T - 1/T_0))",
        "Schwarzl and Staverman 1952, J. Appl. Phys. 23(8)", ELEMENT, DAMPER,
    ),
    "rubber_friction": _law(
        Kind(states.rubber_friction), "F = F_r + s |y - y_r| (F_m - s F_r)/(x (1 - s F_r/F_m) + |y - y_r|), s = sgn(v)",
        "Berg 1998, Veh. Syst. Dyn. 30(3-4)", ELEMENT,
    ),
    "overshooting_friction": _law(
        Kind(states.overshooting_friction), "F = 2 F_c z_1 - F_c z_2, dz_i = (sgn(v) - z_i) |dy|/x_i",
        "Bliman and Sorine 1995, Proc. 3rd European Control Conference", ELEMENT, DAMPER,
    ),
    "glass_transition": _law(
        Kind(factors.glass_transition), "k *= 1 - s/(1 + x^2), x = f/f_c exp(B (1/T - 1/T_g))",
        "Ferry 1980, Viscoelastic Properties of Polymers: one relaxation, time and temperature superposed", FACTOR,
    ),
    "payne": _law(
        Kind(factors.payne, most=1.5), "k *= 1 + s/(1 + (A/A_c)^(2 m)), m = 1.5",
        "Kraus 1984, J. Appl. Polym. Sci. Appl. Polym. Symp. 39", FACTOR,
    ),
    "moving_peak": _law(
        Kind(factors.moving_peak, most=2.0), "c *= 1 + 2 s x/(1 + x^2), x = f/f_c exp(B (1/T - 1/T_c))",
        "Zener 1948, Elasticity and Anelasticity of Metals", FACTOR,
    ),
    "running_in": _law(
        Kind(factors.running_in, needs="cycles"), "c *= 1 + s (1 - exp(-(N/N_c)^0.5))",
        "Kohlrausch 1854, Ann. Phys. Chem. 91: a stretched exponential", FACTOR,
    ),
    "field_friction": _law(
        Kind(factors.field_friction, needs="condition"), "F = F_m tanh(u/u_s) tanh(v/v_s)",
        "Phillips 1969, PhD thesis, University of California, Berkeley: Bingham's flow, with a yield force by field",
        DAMPER, ELEMENT,
    ),
}  # fmt: skip
"""By name."""
