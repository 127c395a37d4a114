"""Narrow test plans, in which effects imitate each other: what a diagnosis can't tell there, its next test must."""

from __future__ import annotations

import itertools

from cases import FORMS, IMITATED, SHARES, Case

BAND = ("two neighbouring frequencies", "two by two", "one amplitude")
STROKE = ("neighbouring amplitudes", "one frequency", "two by two")
ANY = ("two neighbouring frequencies", "one frequency", "neighbouring amplitudes", "one amplitude", "two by two")
IMITATIONS = {
    ("relaxation", "stiffness_frequency"): BAND, ("stiffness_frequency", "inertia"): BAND,
    ("relaxation", "inertia"): BAND, ("relaxation", "viscous"): BAND,
    ("oil_damper", "relaxation"): BAND, ("oil_damper", "memory"): STROKE, ("oil_damper", "viscous"): BAND,
    ("inner_mass", "relaxation"): BAND, ("inner_mass", "stiffness_frequency"): BAND,
    ("relaxation_spread", "relaxation"): BAND, ("relaxation_spread", "stiffness_frequency"): BAND,
    ("hardening", "end_stop"): STROKE, ("gap", "end_stop"): STROKE, ("gap", "memory"): STROKE,
    ("play", "gap"): STROKE, ("unilateral_contact", "asymmetry"): STROKE, ("unilateral_contact", "gas_spring"): STROKE,
    ("slip_spread", "memory"): STROKE, ("bouc_wen", "memory"): STROKE, ("slip_spread", "bouc_wen"): STROKE,
    ("directional_slip", "memory"): STROKE,
    ("exponential_stiffening", "hardening"): STROKE, ("exponential_stiffening", "end_stop"): STROKE,
    ("gas_spring", "asymmetry"): STROKE, ("stribeck", "coulomb"): ANY,
    ("rounded_friction", "coulomb"): ANY, ("rounded_friction", "memory"): ("one amplitude",),
    ("displacement_friction", "memory"): STROKE, ("displacement_friction", "coulomb"): ("one amplitude",),
    ("pressed_slip", "displacement_friction"): STROKE, ("pressed_slip", "memory"): STROKE,
    ("self_centring", "memory"): ("one amplitude",), ("self_centring", "displacement_friction"): ("one amplitude",),
    ("coulomb", "viscous"): ANY, ("coulomb", "memory"): ANY, ("viscous", "quadratic_damping"): ANY,
    ("viscous", "delay"): ANY, ("asymmetry", "offset"): ANY, ("asymmetry", "directional_damping"): ANY,
    ("damping_temperature", "loosening"): ("two temperatures",), ("contact_growth", "loosening"): ("two temperatures",),
    ("damping_temperature", "fade"): ("two temperatures",),
}  # fmt: skip
"""Pairs of effects that imitate each other, and the plans in which they do."""


def narrow_cases() -> list[Case]:
    """Give each of every pair as the truth, in each plan, in a fixed order."""
    cases = []
    for form, (pair, plans) in itertools.product(FORMS, IMITATIONS.items()):
        for (truth, rival), plan in itertools.product((pair, pair[::-1]), plans):
            for strength, noise in itertools.product(SHARES, IMITATED):
                cases.append(Case("narrow", (truth,), form, strength, noise, plan, rival=rival))
    return cases
