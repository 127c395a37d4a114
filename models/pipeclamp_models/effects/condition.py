"""A further test condition u: stiffness, damping and slip force times exp(p u + q u^2), each its own; and a force.

Where slip forces differ between the directions, that on the way down has a factor exp(p u) besides.
"""

import re

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Family, Parameter
from pipeclamp_models.equations.literature import SPENCER
from pipeclamp_models.equations.symbols import F_typical, condition_size, condition_symbol, y

MOST = 10.0
"""A condition changes a coefficient by no more than a factor exp(10)."""


def follow(argument: str) -> Effect:
    """Give the effect of a column of runs.csv.

    Raises:
        ValueError: the argument can't be a column's name.
    """
    if not re.fullmatch(r"\w[\w .%/()-]*", argument):
        raise ValueError("the name of a numeric column of runs.csv, for example condition:current_A")
    u, size = condition_symbol(argument), condition_size(argument)
    parameters: list[Parameter] = []
    scales: dict[str, sp.Expr] = {}
    for role, letter in (("stiffness", "k"), ("damping", "c"), ("slip", "z")):
        slope, bend = sp.symbols(f"{letter}_{u}1 {letter}_{u}2", real=True)
        parameters += [
            Parameter(
                slope,
                f"1/[{argument}]",
                f"slope of the log of the {role}",
                0.0,
                -MOST / size,
                MOST / size,
                neutral=0.0,
                follows=(u,),
                typical=0.2 / size,
            ),
            Parameter(
                bend,
                f"1/[{argument}]^2",
                f"bend of the log of the {role}",
                0.0,
                -MOST / size**2,
                MOST / size**2,
                neutral=0.0,
                follows=(u,),
                levels=3,
            ),
        ]
        scales[role] = sp.exp(slope * u + bend * u**2)
    apart, mean = sp.symbols(f"zn_{u}1 F_{u}1", real=True)
    scales["slip down"] = sp.exp(apart * u)
    parameters += [
        Parameter(
            apart,
            f"1/[{argument}]",
            "slope of the log of the slip force on the way down over that on the way up",
            0.0,
            -MOST / size,
            MOST / size,
            neutral=0.0,
            follows=(u,),
            typical=0.2 / size,
            if_scaled=True,
        ),
        Parameter(
            mean,
            f"N/[{argument}]",
            "slope of a mean force",
            0.0,
            neutral=0.0,
            follows=(u,),
            typical=0.05 * F_typical / size,
        ),
    ]
    return Effect(
        id="condition",
        part="clamp",
        does="stiffness, damping, slip force and a mean force follow a column of runs.csv",
        source=f"{SPENCER}: coefficients of a damper that follow its voltage. Here their "
        "logarithms do, so that none changes its sign",
        looks_like=f"error that follows {argument}",
        imitated_by=(),
        special_cases=("offset",),  # of a column that hardly varies
        told_apart_by=f"{argument} varied in another order than the other conditions",
        parameters=tuple(parameters),
        scales=scales,
        force=mean * u,
        energy=mean * u * y,
        argument=argument,
    )


EFFECT = Family("condition", "the name of a numeric column of runs.csv", None, follow)
