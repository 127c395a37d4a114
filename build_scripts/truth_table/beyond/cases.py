"""The cases of the discovery: laws beyond the catalogue, alone and beside its effects, nothing, and its effects."""

from __future__ import annotations

import itertools

from cases import DESIGNS, FORMS, NOISES, STRENGTHS, Case
from hidden import EFFECTS

from beyond.registry import LAWS

NONE_REPEATS = 6
COMPANY = ("damping_temperature", "memory", "contact_growth")
"""Effects of the catalogue that laws are hidden beside, in turn: a device rarely lacks one thing alone."""


def beyond_cases() -> list[Case]:
    """Give every case, in a fixed order. Test plans and noises take turns."""
    cases: list[Case] = []
    for form in FORMS:
        for number, (law, strength) in enumerate(itertools.product(LAWS, STRENGTHS)):
            noise, design = _turn(number)
            cases.append(Case("beyond", (law,), form, strength, noise, design))
        for number, (noise, design) in itertools.product(range(NONE_REPEATS), itertools.product(NOISES, DESIGNS)):
            cases.append(Case("none", (), form, "", noise, design, number))
        for number, effect in enumerate(EFFECTS):
            noise, design = _turn(number)
            cases.append(Case("effect", (effect,), form, ("middle", "strong")[number // 4 % 2], noise, design))
    # last, so that a share of the others is drawn as before
    for form, (number, law) in itertools.product(FORMS, enumerate(LAWS)):
        noise, design = _turn(number)
        company, strength = COMPANY[number % 3], ("strong", "middle")[number // 3 % 2]
        cases.append(Case("beside", (law, company), form, strength, noise, design))
    return cases


def _turn(number: int) -> tuple[str, str]:
    """Give noise and test plan of a case, so that each goes with every strength."""
    return tuple(NOISES)[(number + number // 6) % 2], tuple(DESIGNS)[number // 2 % 2]
