"""Play: a clearance in series with the whole clamp, which moves only while it is pushed, at y - e in place of y."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter, Stage, State
from pipeclamp_models.equations.literature import NORDIN, WORDEN
from pipeclamp_models.equations.symbols import A_typical, F_moved, F_path, v, y, y_previous

g_p, e, s = sp.symbols("g_p e_p s_p", real=True)
way, pushed, pulled, place = sp.symbols("way_p F_pushed F_pulled e_next", real=True)
at_pushing, at_pulling = sp.symbols("s_pushed s_pulled", real=True)
stood = y_previous - e


def within(value: sp.Expr, most: sp.Expr) -> sp.Expr:
    """Give a value, or the nearer end of -most to most."""
    return sp.Piecewise((most, value > most), (-most, value < -most), (value, True))


def share_of(move: sp.Expr) -> sp.Expr:
    """Give the share of the velocity at which the clamp makes a move of its own in a step."""
    return sp.Max(-1, sp.Min(1, move / way))


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
        Stage(at_pushing, "-", "share of the velocity that leads to the one end", share_of(y - g_p - stood)),
        Stage(at_pulling, "-", "share of the velocity that leads to the other end", share_of(y + g_p - stood)),
        Stage(pushed, "N", "force at the one end, which pushes where it is positive", F_moved(y - g_p, at_pushing)),
        Stage(pulled, "N", "force at the other end, which pulls where it is negative", F_moved(y + g_p, at_pulling)),
        Stage(
            place, "mm", "place within the clearance after the step",
            sp.Piecewise(
                (within(e, g_p), sp.Eq(y, y_previous)), (g_p, pushed > 0), (-g_p, pulled < 0),
                (within(y - stood, g_p), True),
            ),
        ),
    ),
    states=(
        State(e, "mm", "place within the clearance, from its middle", update=place),
        State(
            s, "-", "share of the velocity at which the clamp moves",
            update=sp.Piecewise((s, sp.Eq(y, y_previous)), (share_of(y - place - stood), True)), start=1.0,
        ),
    ),
    replaces={y: y - e, v: s * v},
    passes=sp.Piecewise((sp.Max(F_path, 0), e >= g_p), (0, True))
    + sp.Piecewise((sp.Min(F_path, 0), e <= -g_p), (0, True)),
)  # fmt: skip
