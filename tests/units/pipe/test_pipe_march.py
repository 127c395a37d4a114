"""Many models marched at once say what SciPy's integration of each alone says."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from cantilever import cantilever

from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.transient.march import HeldLaw, Variant, march
from pipeclamp_system.transient.monolithic import clamp_equations, solve_monolithic

pipe_text = partial(cantilever, ratio=0.03, up_to_Hz=50, clamps={"one": 1.2, "two": 2.0}, probes={"tip": 3.0})
TIME = np.arange(201) / 200
EVERY = 4
POWER = {"k10": 8.0, "k30": 1.0, "c0": 2.0, "alpha0": 0.7}
MEMORY = {"k10": 8.0, "c0": 0.05, "alpha0": 1.0, "k_s": 6.0, "z_s": 4.0}


def law(base: str, values: dict[str, float]) -> Law:
    structure = Structure(base)
    known = structure.held() | values
    return Law(
        structure, {entry.name: known.get(entry.name, 0.0) for entry in structure.equations.parameters}, 1.0, 0.01
    )


def shaken(t):
    return 2.0 * np.sin(2 * np.pi * (4.0 * t + 2.0 * t**2))


@pytest.mark.parametrize(
    ("first", "flow", "off"), [("power", None, 2e-3), ("memory", None, 2e-2), ("power", 15.0, 2e-3)]
)
def test_each_of_several_models_is_integrated_rightly(first, flow, off):
    pipe = reduce(parse_pipe(pipe_text(flow_m_s=flow)))
    softer = replace(pipe, damping=tuple(2 * value for value in pipe.damping))
    one, two = law(first, POWER if first == "power" else MEMORY), law("power", POWER)
    weaker = replace(two, values={**two.values, "k10": 4.0})
    held = [tuple(HeldLaw(own, 0.5, 8.0, 293.15) for own in pair) for pair in ((one, two), (one, weaker))]
    variants = [Variant(pipe, held[0]), Variant(softer, held[1])]
    fine = np.arange(EVERY * (TIME.size - 1) + 1) / (200 * EVERY)
    found = [march(variants, shaken(fine), fine[1], EVERY, [order]) for order in range(3)]
    for row, variant in enumerate(variants):
        equations = [clamp_equations(own.law, 0.5, 8.0, 293.15) for own in variant.laws]
        exact = solve_monolithic(variant.pipe, equations, lambda t: float(shaken(t)), TIME, 1e-6)
        for order, of in enumerate(("probes", "probe_velocity", "probe_acceleration")):
            wanted = getattr(exact, of)
            assert np.std(found[order].probes[row] - wanted) < (5 if order == 2 else 1) * off * np.std(wanted)
        assert np.std(found[0].displacement[row] - exact.displacement) < off * np.std(exact.displacement)


def test_half_the_step_errs_by_a_quarter_at_most():
    pipe = reduce(parse_pipe(pipe_text()))
    held = tuple(HeldLaw(law("power", POWER), 0.5, 8.0, 293.15) for _ in range(2))
    found = []
    for every in (2, 4, 16):
        fine = np.arange(every * (TIME.size - 1) + 1) / (200 * every)
        found.append(march([Variant(pipe, held)], shaken(fine), fine[1], every, [0]).probes)
    assert np.std(found[1] - found[2]) < np.std(found[0] - found[2]) / 4


@pytest.mark.parametrize(
    ("excitation", "words"),
    [(lambda t: 1e300 * t, "fails after t = "), (lambda t: float("nan") if t > 0.5 else 1.0, "beyond all numbers")],
)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_an_integration_that_fails_is_no_reference(excitation, words):
    equations = [clamp_equations(law("power", POWER), 0.5, 6.0, 293.15)] * 2
    with pytest.raises(ArithmeticError, match=words):
        solve_monolithic(reduce(parse_pipe(pipe_text())), equations, excitation, TIME, 1e-6)
