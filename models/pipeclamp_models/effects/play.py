"""Play: a clearance in series with the whole clamp, which moves only while it is pushed, at y - e in place of y."""

import sympy as sp

from pipeclamp_models.equations.effect import Effect, Parameter, Stage, State
from pipeclamp_models.equations.literature import NORDIN, WORDEN
from pipeclamp_models.equations.symbols import A_typical, F_path, F_slow, v, y, y_previous, y_r

g_p, e, s = sp.symbols("g_p e_p s_p", real=True)
held, fall, free, place = sp.symbols("F_stood F_fall e_free e_next", real=True)
stood = y_previous - e

FAR = sp.Integer(10**6)
"""mm/N: a path that doesn't spring back goes so far, that is to the clearance's end. No size of a clamp comes near."""

EFFECT = Effect(
    id="play",
    part="clamp",
    does="a clearance before the whole clamp, taken up anew after each reversal",
    source=f"{NORDIN}: the place within the clearance is a state, and the force vanishes between its ends. Here a path "
    f"that is let go comes to rest at once, without its dampers; {WORDEN}, on backlash",
    looks_like="a flat piece at zero force after each reversal; where friction holds the clamp, at another place each "
    "way",
    imitated_by=("gap",),
    told_apart_by="a small cycle ridden on a large one: play opens at every reversal, a gap about zero at zero only",
    parameters=(
        Parameter(
            g_p, "mm", "half the clearance", tuple(part * A_typical for part in (0.01, 0.05, 0.2)), lower=0.0,
            upper=A_typical, neutral=0.0,
        ),
    ),
    stages=(
        Stage(held, "N", "force where the clamp's own end stood, held still", F_slow(stood)),
        Stage(fall, "N", "its fall on a way back by y_r", (held - F_slow(stood - y_r * sp.sign(e))) * sp.sign(e)),
        Stage(
            free, "mm", "place within the clearance if nothing pushed",
            sp.Piecewise(
                (y - stood + held * sp.Piecewise((y_r / fall, fall > 0), (FAR, True)), sp.Ne(y, y_previous)), (e, True)
            ),
        ),
        Stage(
            place, "mm", "place within the clearance",
            sp.Piecewise((g_p, free > g_p), (-g_p, free < -g_p), (free, True)),
        ),
    ),
    states=(
        State(e, "mm", "place within the clearance, from its middle", update=place),
        State(
            s, "-", "share of the motion that the clamp takes part in",
            update=sp.Piecewise(
                (sp.Max(0, sp.Min(1, (y - place - stood) / (y - y_previous))), sp.Ne(y, y_previous)), (s, True)
            ),
            start=1.0,
        ),
    ),
    replaces={y: y - e, v: s * v},
    passes=sp.Piecewise((sp.Max(F_path, 0), e >= g_p), (0, True))
    + sp.Piecewise((sp.Min(F_path, 0), e <= -g_p), (0, True)),
)  # fmt: skip
