"""Play: a clearance in series with the whole clamp, which moves only while it is pushed, at y - e in place of y."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter, Stage, State
from pipeclamp_models.equations.literature import NORDIN, WORDEN
from pipeclamp_models.equations.symbols import A_typical, F_moved, F_path, v, v_r, y, y_previous

g_p, e, F, L = sp.symbols("g_p e_p F_p L_p", real=True)
way, pushed, pulled, struck, place = sp.symbols("way_p F_pushed F_pulled F_struck e_next", real=True)
at_pushing, at_pulling, let_go, lacks = sp.symbols("s_pushed s_pulled x_p L_next", real=True)
to_pushing, to_pulling, rounded = sp.symbols("v_pushed v_pulled v_rounded", real=True)
stood = y_previous - e
free = sp.Abs(e) < g_p

AT_REST, SHARP = 1e-6, 1e-9
"""Parts of v_r: how slow a free clamp slides at least, and below what sgn v is smooth then. So slow, only what steps at
rest has a force: dry friction, whole, and no power of v."""


def within(value: sp.Expr, most: sp.Expr) -> sp.Expr:
    """Give a value, or the nearer end of -most to most."""
    return sp.Piecewise((most, value > most), (-most, value < -most), (value, True))


def share_of(move: sp.Expr) -> sp.Expr:
    """Give the share of a step in which the clamp makes a move of its own; below 0 against the step's."""
    return sp.Max(-1, sp.Min(1, move / way))


def speed_to(place: sp.Expr, share: sp.Expr) -> sp.Expr:
    """Give the velocity at which the clamp reaches a place: the pipe's, or against it.

    Of a step in which the pipe turned, a free clamp slides as slow as it may.
    """
    as_pipe = sp.Max(v * sp.sign(way), AT_REST * v_r)
    return sp.Piecewise((sp.sign(place - stood) * as_pipe, free), (v * sp.sign(share), True))


def fallen(before: sp.Expr, after: sp.Expr) -> sp.Expr:
    """Give the share of a step after which a force that changes its sign in it, straight, is zero."""
    return before / (before - after)


def at_ends(one: sp.Expr, other: sp.Expr, at: sp.Expr) -> sp.Expr:
    """Give what holds at the end that pushes, or the one that pulls; 0 between them."""
    return sp.Piecewise((one, at >= g_p), (0, True)) + sp.Piecewise((other, at <= -g_p), (0, True))


EFFECT = Effect(
    id="play",
    part="clamp",
    does="a clearance before the whole clamp, taken up anew after each reversal",
    source=f"{NORDIN}: the place within the clearance is a state, and the force vanishes between its ends. Here a "
    f"clamp that is let go stays where its friction holds it; {WORDEN}, on backlash",
    looks_like="a flat piece at zero force after each reversal; where friction holds the clamp, at another place each "
    "way",
    imitated_by=("gap",),
    told_apart_by="a small cycle ridden on a large one: play opens at every reversal, a gap about zero at zero only",
    parameters=(
        Parameter(
            g_p, "mm", "half the clearance", tuple(part * A_typical for part in (0.0003, 0.003, 0.02, 0.15)), lower=0.0,
            upper=A_typical, neutral=0.0, typical=0.05 * A_typical,
        ),
    ),
    stages=(
        Stage(
            way, "mm", "move of the step; 1 where there is none",
            sp.Piecewise((1, sp.Eq(y, y_previous)), (y - y_previous, True)),
        ),
        Stage(at_pushing, "-", "share of the step in which the one end moves the clamp", share_of(y - g_p - stood)),
        Stage(at_pulling, "-", "share of the step in which the other end does", share_of(y + g_p - stood)),
        Stage(to_pushing, "mm/s", "velocity at which the clamp reaches the one end", speed_to(y - g_p, at_pushing)),
        Stage(to_pulling, "mm/s", "velocity at which it reaches the other end", speed_to(y + g_p, at_pulling)),
        Stage(
            rounded, "mm/s", "velocity below which sgn v is smooth then",
            sp.Piecewise((SHARP * v_r, free), (v_r, True)),
        ),
        Stage(
            pushed, "N", "force at the one end, which pushes where it is positive",
            F_moved(y - g_p, to_pushing, rounded),
        ),
        Stage(
            pulled, "N", "force at the other end, which pulls where it is negative",
            F_moved(y + g_p, to_pulling, rounded),
        ),
        Stage(struck, "N", "force with which the clamp begins to move from where it stood", F_moved(stood, v, v_r)),
        Stage(
            let_go, "mm", "where the clamp stays that is let go: its force falls straight to zero in the step",
            stood
            + sp.Piecewise(
                (fallen(F, pushed) * (y - g_p - stood), sp.And(F > 0, pushed <= 0)),
                (fallen(F, pulled) * (y + g_p - stood), sp.And(F < 0, pulled >= 0)),
                (0, True),
            ),
        ),
        Stage(
            place, "mm", "place within the clearance after the step",
            sp.Piecewise(
                (within(e, g_p), sp.Eq(y, y_previous)), (g_p, pushed > 0), (-g_p, pulled < 0),
                (within(y - let_go, g_p), True),
            ),
        ),
        Stage(
            lacks, "N", "what the force lacks where it sets in within the step",
            at_ends(
                sp.Piecewise((0, e >= g_p), ((1 - sp.Abs(at_pushing)) * sp.Max(struck, 0), True)),
                sp.Piecewise((0, e <= -g_p), ((1 - sp.Abs(at_pulling)) * sp.Min(struck, 0), True)),
                place,
            ),
        ),
    ),
    states=(
        State(e, "mm", "place within the clearance, from its middle", update=place),
        State(
            F, "N", "force that comes through",
            update=sp.Piecewise(
                (F, sp.Eq(y, y_previous)),
                (at_ends(sp.Max(pushed - lacks, 0), sp.Min(pulled - lacks, 0), place), True),
            ),
        ),
        State(
            L, "N", "what it lacks of the force of a step whose first part moved nothing",
            update=sp.Piecewise((L, sp.Eq(y, y_previous)), (lacks, True)),
        ),
    ),
    replaces={y: y - e, v: v * (1 - sp.Max(0, sp.sign(g_p - sp.Abs(e))))},  # it stands where it is free
    passes=at_ends(sp.Max(F_path - L, 0), sp.Min(F_path - L, 0), e),
)  # fmt: skip
