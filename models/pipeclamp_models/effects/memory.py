"""Elastic-slip (Jenkins) elements in parallel: dz = k_s dy while |z| < z_s, else z = +-z_s."""

from collections.abc import Mapping

import sympy as sp

from pipeclamp_models.equations.effect import Coefficient, Effect, Family, Parameter, Refinement, State
from pipeclamp_models.equations.literature import IWAN, JENKINS, JIANG, MASING
from pipeclamp_models.equations.symbols import A_typical, F_typical, compliance, y, y_previous

MOST_ELEMENTS = 6
RESOLVED = 3
"""Elements up to which tests resolve a spread of slip forces; a diagnosis goes no further by itself."""


def suffixes(count: int) -> list[str]:
    """Give what the symbols of each of so many elements end in."""
    return [""] if count == 1 else [str(index) for index in range(1, count + 1)]


def one_more(count: int) -> Refinement | None:
    """Give the effect with one more element than so many: the strongest in two, one slipping early and one late.

    Which of several elements slips is seen along the loop, not in its area.
    """
    if count == MOST_ELEMENTS:
        return None

    def start(values: Mapping[str, float]) -> dict[str, float]:
        elements = sorted(
            ((values[f"k_s{suffix}"], values[f"z_s{suffix}"]) for suffix in suffixes(count)), key=lambda each: each[1]
        )
        stiffness, slip = elements.pop()
        elements += [(stiffness / 2, share * slip / 2) for share in (0.5, 1.5)]
        return {
            f"{symbol}{suffix}": value
            for suffix, element in zip(suffixes(count + 1), elements, strict=True)
            for symbol, value in zip(("k_s", "z_s"), element, strict=True)
        }

    return Refinement(f"memory:{count + 1}", start, at_once=count < RESOLVED, seen_in_metrics=False)


def elements(argument: str) -> Effect:
    """Give the effect with as many elements as the argument says.

    Raises:
        ValueError: the argument is not a whole number from 1 to 6.
    """
    if not argument.isdigit() or not 1 <= int(argument) <= MOST_ELEMENTS:
        raise ValueError(f"the number of elastic-slip elements, 1 to {MOST_ELEMENTS}, for example memory:2")
    count = int(argument)
    parameters: list[Parameter] = []
    states: list[State] = []
    coefficients: list[Coefficient] = []
    energy = sp.Integer(0)
    for index, suffix in enumerate(suffixes(count), 1):
        k_s, z_s, z = sp.symbols(f"k_s{suffix} z_s{suffix} z{suffix}", real=True)
        strength, stiffness = sp.symbols(f"slip{suffix} stick{suffix}", real=True)
        trial = z + stiffness * (y - y_previous)
        coefficients.append(Coefficient(strength, "N", "slip", z_s))
        coefficients.append(Coefficient(stiffness, "N/mm", "sticking", k_s))
        # Elastic limits from a small part of the amplitude to most of it, so that each element has its own place.
        limits = [share * index * A_typical for share in (0.05, 0.2, 0.6)]
        slips = [share * F_typical / count for share in (0.15, 0.12, 0.08)]
        parameters += [
            Parameter(
                k_s,
                "N/mm",
                "stiffness of the element while it sticks",
                tuple(slip / limit for slip, limit in zip(slips, limits, strict=True)),
                lower=0.0,
                upper=200 * F_typical / A_typical,
            ),
            Parameter(z_s, "N", "slip force of the element", tuple(slips), lower=0.0, upper=10 * F_typical),
        ]
        states.append(
            State(
                z,
                "N",
                "force of the element",
                update=sp.Piecewise((strength, trial > strength), (-strength, trial < -strength), (trial, True)),
            )
        )
        energy += compliance(stiffness) * z**2 / 2
    return Effect(
        id="memory",
        part="clamp",
        does="elastic-slip (Jenkins) elements: force depends on the way here",
        source=f"{JIANG}, Eq. 7 and Fig. 10, with elastic unloading; {JENKINS}; {IWAN}; {MASING}",
        looks_like="force just after reversals changes along a straight line and then yields; rate-independent; "
        "k1 that falls with A",
        imitated_by=(
            "coulomb",
            "power_damping",
            "gap",
            "slip_spread",
            "bouc_wen",
            "directional_slip",
            "pressed_slip",
        ),
        told_apart_by="a small cycle ridden on a large one: only memory closes a small loop with its own stiff slope",
        parameters=tuple(parameters),
        coefficients=tuple(coefficients),
        force=sp.Add(*(state.symbol for state in states)),
        states=tuple(states),
        energy=energy,
        argument="" if count == 1 else str(count),
        refinement=one_more(count),
    )


EFFECT = Family("memory", "the number of elastic-slip elements", "1", elements, numbered=True)
