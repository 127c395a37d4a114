"""No law of the table of discovery is one term of the grammar: how near the nearest comes, of laws without memory."""

import itertools

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import minimize

from pipeclamp_identification.discovery.grammar import RATE, STRENGTH, terms
from pipeclamp_models.base.signals import REFERENCES
from pipeclamp_models.realise.array_source import ArrayPrinter
from pipeclamp_models.realise.sizes import number_of

SHAPE = {"limit": 0.2, "speed": 1.0, "stop": 0.7, "sign": 1.0, "contact": 420.0, "cycles": 100.0, "tau": 0.06}
SIZES = {
    "A_typical": 0.56, "A_highest": 1.0, "F_typical": 900.0, "f_typical": 2.5, "f_lowest": 1.0, "f_highest": 5.0,
    "T_lowest": 293.15, "T_highest": 573.15, "N_lowest": 1.0, "N_highest": 1000.0, "y_middle": 0.0, "y_reach": 1.0,
    **REFERENCES,
}  # fmt: skip
SAMPLES = 48
"""Of a cycle."""
OWN_WORD = 0.05
"""Share (rms), of what the base law can't imitate, by which a term differs from a law that is nearly its own word."""
CLOSELY = 8
"""Terms, best at their starts, whose parameters are fitted."""
LAWS = (
    "detents", "bimetal_stop", "bumpers", "thickening_paste", "melting_wax", "cavitating_film", "barrel",
    "jammed_paste", "struck_pad", "shifted_flow", "glass_transition", "payne", "moving_peak", "running_in",
    "field_friction",
)  # fmt: skip


def motions():
    """Sines of the first test plan; cycles seen and the further column go their own ways."""
    from truth import Motion, drive

    random, found = np.random.default_rng(5), []
    for f in (1.0, 3.0, 5.0):
        A, T = np.array(list(itertools.product((0.2, 0.5, 0.8, 1.0), (293.15, 373.15, 573.15)))).T[..., None]
        tones = {1: A[:, 0] * np.exp(-0.5j * np.pi)}
        time, y, v, a = drive(tones, f, SAMPLES * f, SAMPLES)
        level, seen = random.choice([5.0, 10.0, 20.0], A.shape), 60.0 * random.permutation(len(A))[:, None]
        found.append(
            Motion(time, y, v, a, tuple(tones.items()), A, T, 2.3 + 0 * A, level, seen, f, np.zeros((len(A), 4)))
        )
    return found


def over_the_cycle(every, value):
    """Give something of all motions at the samples of their last cycle, shape (all samples,)."""
    return np.concatenate([np.broadcast_to(value(m), m.y.shape)[:, -8 * SAMPLES :: 8].ravel() for m in every])


def freed_of(known):
    """What base laws can't imitate: give what is left of a force beside stiffness and damping that follow A, f, T."""
    y, v, A, f, T = (known[name] for name in "yvAfT")
    slow, size = np.sign(v) * np.sqrt(np.abs(v)), np.log(np.abs(v) + 1e-9)
    forces = [y, y * np.log(A), y * np.log(T), y**3, y**3 * np.log(A), y**3 * np.log(T)]
    forces += [slow * one * level for one in (1, size) for level in (1, np.log(A), np.log(f))]
    basis, _ = np.linalg.qr(np.stack([force / np.linalg.norm(force) for force in forces], axis=1))
    return lambda force: force - basis @ (basis.T @ force)


def function(expression):
    free = sorted(expression.free_symbols, key=str)
    compiled = sp.lambdify(free, expression, modules="numpy", printer=ArrayPrinter)
    names = [symbol.name for symbol in free]
    return lambda **known: compiled(*(known[name] for name in names))


def misses(wanted, free, force):
    """The share of the first that no multiple of the second, freed, reaches."""
    values = free(np.broadcast_to(force, wanted.shape))
    length = values @ values
    if not np.isfinite(length) or length < 1e-12:
        return 1.0
    return float(np.linalg.norm(wanted - values * (values @ wanted) / length) / np.linalg.norm(wanted))


def changes_of(known, base):
    """Each term without memory: what a unit of its strength does to the force, of its parameters; and their starts."""
    scaled = {
        "stiffness": known["y"] * (base.k10 + base.k30 * known["y"] ** 2),
        "damping": np.sign(known["v"]) * np.sqrt(np.abs(known["v"])),
    }
    for term in terms(("A", "f", "T", "N"), {"w": 20.0}):
        effect, linear = term.effect, STRENGTH
        if term.family == "factor":
            ((role, factor),) = effect.scales.items()
            if str(role) not in scaled:
                continue
            rate, linear = sp.Symbol(RATE, real=True), RATE
            slope, direction = function(sp.diff(sp.log(factor), rate).subs(rate, 0)), scaled[str(role)]

            def change(slope=slope, direction=direction, **values):
                return direction * slope(**known, **values)
        elif effect.states:
            continue
        else:
            force = function(effect.force.subs(sp.Symbol(STRENGTH, real=True), 1))

            def change(force=force, **values):
                return force(**known, **values)

        own = [one for one in effect.parameters if one.name != linear]
        count = max(len(one.starts) for one in effect.parameters)
        starts = [
            {one.name: number_of(one.starts[start % len(one.starts)], SIZES) for one in own} for start in range(count)
        ]
        yield change, starts


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # parameters that are sought may overflow
def test_no_law_without_memory_is_nearly_one_term():
    from beyond import registry
    from cases import draw_base
    from truth import force

    every, base = motions(), draw_base(np.random.default_rng(3))
    slow = {"A": lambda m: m.A, "f": lambda m: m.f, "T": lambda m: m.T, "N": lambda m: m.cycles_seen}
    fast = {"y": lambda m: m.y, "v": lambda m: m.v, "u_w": lambda m: m.u}
    known = {name: over_the_cycle(every, value) for name, value in {**slow, **fast}.items()}
    free = freed_of(known)
    known |= {**REFERENCES, "y_r": 0.002, "v_r": 0.01}
    all_changes = list(changes_of(known, base))
    at_starts = [(change, start, change(**start)) for change, starts in all_changes for start in starts]
    nearest = {}
    for name in LAWS:
        kind = registry.LAWS[name].kind

        def added(motion, kind=kind):
            return force(base, motion, (kind.part(motion, base, False, 0.05, SHAPE),)) - force(base, motion, ())

        wanted = free(over_the_cycle(every, added))
        ranked = sorted(((misses(wanted, free, values), place) for place, (*_, values) in enumerate(at_starts)))
        nearest[name] = ranked[0][0]
        for _, place in ranked[:CLOSELY]:
            change, start, _ = at_starts[place]
            first = np.array(list(start.values()))

            def miss(log, change=change, start=start, first=first, wanted=wanted):
                return misses(wanted, free, change(**dict(zip(start, first * np.exp(log), strict=True))))

            if start:
                found = minimize(miss, np.zeros(len(first)), method="Nelder-Mead", options={"maxfev": 100})
                nearest[name] = min(nearest[name], found.fun)
    assert {name: share for name, share in nearest.items() if share < OWN_WORD} == {}
