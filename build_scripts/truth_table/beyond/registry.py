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
    "arctan_spring": _law(
        Kind(plain.arctan_spring), "F = (2/pi) F_s arctan(y/y_s)", CLOSED, SPRING,
    ),
    "lateral_springs": _law(
        Kind(plain.lateral_springs, most=2.0), "F = k y (1 - l/sqrt(y^2 + a^2))",
        "Cao, Wiercigroch, Pavlovskaia, Grebogi and Thompson 2006, Phys. Rev. E 74, 046218", SPRING,
    ),
    "sine_spring": _law(
        Kind(plain.sine_spring), "F = F_s sin(2 pi y/l)", "Frenkel and Kontorova 1938 (their substrate)", SPRING,
    ),
    "log_spring": _law(
        Kind(plain.log_spring), "F = F_s sgn(y) ln(1 + |y|/y_s)", CLOSED, SPRING,
    ),
    "pressed_contact": _law(
        Kind(plain.pressed_contact), "F = F_s ((1 + y/d)+^1.5 - 1)",
        "Hertz 1882, J. reine angew. Math. 92, preloaded", SPRING,
    ),
    "magnets": _law(
        Kind(plain.magnets, most=3.0), "F = F_s ((1 - y/d)^-4 - (1 + y/d)^-4)",
        "Mann and Sims 2009, J. Sound Vib. 319(1-2), force of dipoles on one axis", SPRING,
    ),
    "limited_chain": _law(
        Kind(plain.limited_chain, most=5.0), "F = k y (y/y_m)^2 / (1 - (y/y_m)^2)",
        "Gent 1996, Rubber Chem. Technol. 69(1): his denominator", SPRING,
    ),
    "eddy_brake": _law(
        Kind(plain.eddy_brake), "F = 2 F_m (v/v_c) / (1 + (v/v_c)^2)", "Wouterse 1991, IEE Proc. B 138(4)", DAMPER,
    ),
    "activated_flow": _law(
        Kind(plain.activated_flow), "F = F_e asinh(v/v_e)", "Eyring 1936, J. Chem. Phys. 4(4)", DAMPER,
    ),
    "squeeze_film": _law(
        Kind(plain.squeeze_film), "F = c v / (1 - y/h)^3", "Reynolds 1886, Phil. Trans. R. Soc. 177", DAMPER,
    ),
    "thinning_oil": _law(
        Kind(plain.thinning_oil, most=3.0), "F = c v (1 + (v/v_c)^2)^((n - 1)/2)",
        "Carreau 1972, Trans. Soc. Rheol. 16(1)", DAMPER,
    ),
    "yielding_paste": _law(
        Kind(plain.yielding_paste, most=1.5), "F = F_y sgn(v) (1 - exp(-|v|/v_p))",
        "Papanastasiou 1987, J. Rheol. 31(5)", DAMPER,
    ),
    "lateral_damper": _law(
        Kind(plain.lateral_damper), "F = c v y^2/(a^2 + y^2)", "Tang and Brennan 2013, J. Sound Vib. 332(6)", DAMPER,
    ),
    "capstan": _law(
        Kind(plain.capstan), "F = F_c exp(y/y_c) tanh(v/v_s)", "Euler 1769 and Eytelwein 1808: belt friction", DAMPER,
        ELEMENT,
    ),
    "creeping_arm": _law(
        Kind(states.creeping_arm), "dF/dt = k (v - v_e sinh(F/F_e))",
        "Haward and Thackray 1968, Proc. R. Soc. A 302: their dashpot", ELEMENT,
    ),
    "viscoplastic": _law(
        Kind(states.viscoplastic), "dF/dt = k (v - v_p sgn(F) (|F|/F_y - 1)+)", "Perzyna 1966, Adv. Appl. Mech. 9",
        ELEMENT,
    ),
    "bristles": _law(
        Kind(states.bristles), "dz/dt = v - |v| z/g(v), g = z_s (1 + b exp(-(v/v_s)^2))",
        "Canudas de Wit, Olsson, Astroem and Lischinsky 1995, IEEE Trans. Autom. Control 40(3)", ELEMENT,
    ),
    "flag": _law(
        Kind(states.flag), "dF = k dy within [min(k |y|, F_r), min(k |y|, F_y)] sgn(y)",
        "Christopoulos, Filiatrault and Folz 2002, Earthquake Eng. Struct. Dyn. 31(5)", ELEMENT,
    ),
    "hardening_plastic": _law(
        Kind(states.hardening_plastic, most=2.0), "|F - X| <= F_y, dX = C dp - g X |dp|",
        "Armstrong and Frederick 1966, CEGB Report RD/B/N 731", ELEMENT,
    ),
    "glass_transition": _law(
        Kind(factors.glass_transition), "k *= 1 - s/(1 + exp(-(T - T_g)/w))", CLOSED, FACTOR,
    ),
    "payne": _law(
        Kind(factors.payne, most=1.5), "k *= 1 + s/(1 + (A/A_c)^(2 m)), m = 1.5",
        "Kraus 1984, J. Appl. Polym. Sci. Appl. Polym. Symp. 39", FACTOR,
    ),
    "loss_peak": _law(
        Kind(factors.loss_peak), "c *= 1 + 2 s (f/f_c)/(1 + (f/f_c)^2)",
        "Zener 1948, Elasticity and Anelasticity of Metals", FACTOR,
    ),
    "running_in": _law(
        Kind(factors.running_in, needs="cycles"), "c *= 1 + s ln(1 + N/N_c)", CLOSED, FACTOR,
    ),
    "field_friction": _law(
        Kind(factors.field_friction, needs="condition"), "F = F_m tanh(u/u_s) tanh(v/v_s)",
        "Phillips 1969, PhD thesis, University of California, Berkeley: Bingham's flow, with a yield force by field",
        DAMPER, ELEMENT,
    ),
    "warm_oil": _law(
        Kind(factors.warm_oil), "F = c v exp(B (1/T - 1/T_0))", "Andrade 1930, Nature 125", DAMPER,
    ),
}  # fmt: skip
"""By name."""
