"""What every effect owes: parametrised over the catalogue's folder and over declarations, tested by being there."""

import ctypes
import math
import random
import re
import shutil
import subprocess
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.signals import CONDITION
from pipeclamp_models.base.units import grows_with_force
from pipeclamp_models.equations import literature, symbols
from pipeclamp_models.equations.effect import Effect, Family
from pipeclamp_models.law.catalogue import entries, find_effect, listed, symbols_taken
from pipeclamp_models.law.declaration_files import read_declaration
from pipeclamp_models.law.law import BASES, Law, Structure, bare_for
from pipeclamp_models.realise.arrays import realise
from pipeclamp_models.realise.c import c_source
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion, sinusoids
from pipeclamp_models.realise.scalar import python_source
from pipeclamp_models.realise.scalar_law import parameter_values
from pipeclamp_models.realise.stepping import conditions_of, stepping

ARGUMENTS = {"condition": "condition:current_A"}
DECLARED = tuple(read_declaration(path) for path in sorted((Path(__file__).parent / "declared").glob("*.toml")))
WITH_DECLARED = Structure(declared=DECLARED)
NAMES = [*(ARGUMENTS.get(name, name) for name in entries()), *(declaration.id for declaration in DECLARED)]
FURTHER = {"rho": 2.5, "N": 40.0, "u_current_A": 0.6}
ON_A_BASE = [name for name in NAMES if WITH_DECLARED.effect(name).part != "base"]


def on_a_bare_law(*names):
    """Effects on the plainest law that the first can be added to."""
    bare = bare_for(WITH_DECLARED.effect(names[0]))
    return replace(WITH_DECLARED, base=bare.base, effects=(*bare.effects, *names))


STRUCTURES = [
    *(Structure(base) for base in BASES),
    *(on_a_bare_law(name) for name in ON_A_BASE),
]
COPIES = [declaration.id for declaration in DECLARED if declaration.id.endswith("_copy")]
PUBLICATIONS = [text for name, text in vars(literature).items() if name.isupper()]
SMOOTHING = (0.0126, 0.002)
CYCLES_TO_FORGET = {("relaxation_spread",): 200}
"""Of tests' motions at 3 Hz, where rest isn't forgotten within thirty."""
SCALES = {
    symbols.A_typical: 0.6, symbols.A_highest: 1.0, symbols.F_typical: 1500.0, symbols.f_typical: 3.0,
    symbols.f_lowest: 1.0, symbols.f_highest: 5.0, symbols.T_lowest: 293.15, symbols.T_highest: 573.15,
    symbols.N_lowest: 1.0, symbols.N_highest: 500.0, symbols.y_middle: 0.0, symbols.y_reach: 1.0,
    symbols.condition_size("current_A"): 1.0, **symbols.REFERENCES,
}  # fmt: skip


def sound_values(structure, seed=0):
    """Values near each parameter's start, moved at random so that nothing sits at a neutral point."""
    rng = random.Random(seed)
    values = {}
    for parameter in structure.equations.composed.parameters:
        start = float(sp.sympify(parameter.starts[-1]).subs(SCALES))
        lower, upper = (float(sp.sympify(bound).subs(SCALES)) for bound in (parameter.lower, parameter.upper))
        step = 0.1 * abs(start) or 0.02 * min(1.0, upper - lower)
        values[parameter.name] = min(max(start + step * rng.uniform(0.3, 1.0), lower), upper)
    return values | structure.held()


def sines(A, f, T, samples=512):
    """Sinusoids with a value for every slow signal that effects may use."""
    motion = sinusoids(A, f, T, samples)
    further = {name: np.full_like(motion.slow["A"], value) for name, value in FURTHER.items()}
    return replace(motion, slow={**motion.slow, **further})


source = cache(python_source)
"""The text that goes into an FMU, made once for all values of a law."""


def executed(law):
    """Run the text that goes into an FMU, with a law's values; nothing but math is there for it."""
    scope = {"math": math}
    exec(source(law.structure), scope)
    scope["coefficients"] = partial(scope["coefficients"], parameter_values(law))
    return scope


C_CALLS = """#include <math.h>
{law}
void call_coefficients(const double *p, const double *u, double *k) {{ law_coefficients(p, u, k); }}
void call_step(const double *k, const double *z, const double *m, double *result, double *z_new)
{{ law_step(k, z, m[0], m[1], m[2], m[3], result, z_new); }}
void call_slopes(const double *p, const double *u, const double *z, const double *m, double *slope)
{{ law_slopes(p, u, z, m[0], m[1], m[2], m[3], slope); }}
"""


def compiled_c(structure, folder):
    """Compile a law's C source; give functions that take lists of numbers and the counts of what they return."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("there is no C compiler (cc, gcc or clang) on the path")
    source, library = folder / "law.c", folder / "law.so"
    source.write_text(C_CALLS.format(law=c_source(structure)), encoding="utf-8")
    flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-Wno-unused-const-variable", "-shared", "-fPIC"]
    subprocess.run([compiler, *flags, str(source), "-o", str(library), "-lm"], check=True)
    loaded = ctypes.CDLL(str(library))

    def call(name, *arguments, results):
        outputs = [(ctypes.c_double * max(count, 1))() for count in results]
        given = [(ctypes.c_double * max(len(argument), 1))(*argument) for argument in arguments]
        getattr(loaded, f"call_{name}")(*given, *outputs)
        return [list(output)[:count] for output, count in zip(outputs, results, strict=True)]

    return call


def name_of(structure):
    return "+".join((structure.base, *structure.effects))


@pytest.mark.parametrize("name", NAMES)
def test_an_effect_states_itself(name):
    effect = WITH_DECLARED.effect(name)
    assert isinstance(effect, Effect)
    assert re.fullmatch(r"[a-z_]+", effect.id)
    for text in (effect.does, effect.looks_like, effect.told_apart_by):
        assert len(text) > 8
    for parameter in effect.parameters:
        assert parameter.unit
        assert len(parameter.meaning) > 3
        lower, upper = (float(sp.sympify(bound).subs(SCALES)) for bound in (parameter.lower, parameter.upper))
        for start in parameter.starts:
            assert lower <= float(sp.sympify(start).subs(SCALES)) <= upper
        if parameter.follows:
            assert parameter.neutral is not None, "what may be undetermined needs a value that changes nothing"
    own = {parameter.symbol: parameter for parameter in effect.parameters}
    assert all(own[symbol].neutral is not None for symbol in effect.essence)


@pytest.mark.parametrize("effect", listed(), ids=lambda effect: effect.id)
def test_an_effect_names_a_publication(effect):
    """Author, title, place and year; no file, and nothing that only its author knows."""
    assert any(publication in effect.source for publication in PUBLICATIONS)
    assert re.match(r"[A-Z][a-zü]+(, | and |:| \(eds\.\))", effect.source)
    assert re.search(r"\((19|20)\d\d\)", effect.source)
    assert not re.search(r"\.\w{2,4}\b(?<!doi)", re.sub(r"doi \S+|eds\.|Eq\.|Fig\.", "", effect.source))


def test_publications_are_cited_whole_and_used():
    sources = " ".join(effect.source for effect in listed())
    for publication in PUBLICATIONS:
        assert re.match(r"[A-Z][^:]+: .{10,}, .+ \((19|20)\d\d\)", publication), publication
        assert publication in sources, publication
    assert len(set(PUBLICATIONS)) == len(PUBLICATIONS)


@pytest.mark.parametrize("effect", listed(), ids=lambda effect: effect.id)
def test_an_effect_is_imitated_by_effects(effect):
    assert set(effect.imitated_by) <= set(entries())
    assert effect.many_of in ("", *effect.special_cases)


def test_no_symbol_of_an_effect_is_taken_for_a_column_of_tests():
    """Pictures, answers and steps tell a column's signal by how its name begins."""
    assert [symbol for symbol in symbols_taken() if symbol.startswith(CONDITION)] == []


@pytest.mark.parametrize("name", NAMES)
def test_typical_sizes_lie_within_bounds(name):
    for parameter in WITH_DECLARED.effect(name).parameters:
        lower, size, upper = (
            float(sp.sympify(value).subs(SCALES)) for value in (parameter.lower, parameter.size, parameter.upper)
        )
        assert lower <= size <= upper


@pytest.mark.parametrize("name", NAMES)
def test_an_effect_changes_something(name):
    effect = WITH_DECLARED.effect(name)
    assert effect.force != 0 or effect.scales or effect.replaces or effect.lag != 0


@pytest.mark.parametrize("name", [name for name, entry in entries().items() if isinstance(entry, Family)])
def test_a_family_refuses_a_bad_argument(name):
    with pytest.raises(Exception, match="expected"):
        find_effect(f"{name}:-nonsense")


@pytest.mark.parametrize("structure", STRUCTURES, ids=name_of)
def test_neutral_parameters_change_nothing(structure):
    """With every parameter that has a neutral value at it, the law is the one without those parameters' effects."""
    if not structure.effects:
        pytest.skip("a base law has nothing to be neutral against")
    effect = structure.effect(structure.effects[0])
    if any(parameter.neutral is None for parameter in effect.parameters):
        pytest.skip("the effect is a force of its own, which vanishes at no value in the middle of its range")
    motion = sines([0.2, 1.0], [1.0, 5.0], [293.15, 550.0])
    values = sound_values(structure) | {parameter.name: parameter.neutral for parameter in effect.parameters}
    with_effect, without = structure.equations, Structure(structure.base).equations
    ours = force_of_equations(with_effect, [values[name] for name in with_effect.names], SMOOTHING, motion).force
    theirs = force_of_equations(without, [values[name] for name in without.names], SMOOTHING, motion).force
    np.testing.assert_allclose(ours, theirs, rtol=1e-13, atol=1e-9)


@np.errstate(invalid="ignore")  # of the branch that a choice doesn't take
@pytest.mark.parametrize("structure", STRUCTURES, ids=name_of)
def test_realisations_agree(structure):
    """Arrays and scalar source give the same force, energy and states to 1e-12, over random states."""
    equations = structure.equations_without_rig
    law = Law(structure, sound_values(structure), *SMOOTHING)
    realised = executed(law)
    compiled = realise(equations)
    values = [law.values[name] for name in equations.names]
    rng = random.Random(1)
    for _ in range(50):
        slow = {"A": rng.uniform(0.1, 1.5), "f": rng.uniform(0.5, 8), "T": rng.uniform(300, 600), **FURTHER}
        given = [slow[name] for name in ("A", "f", "T", *realised["CONDITIONS"])]
        y, y_previous, v = rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-30, 30)
        states = [rng.uniform(-100, 100) for _ in equations.states]
        k = realised["coefficients"](*given)
        force, energy, after = realised["step"](k, tuple(states), y_previous, y, v, 0.001)
        ours = compiled.coefficients(*(slow[name] for name in compiled.slow), *values, *SMOOTHING)
        fast = [y, v, 0.0, y_previous, 0.001]
        new = compiled.update(*fast, *states, *ours, *values, *SMOOTHING)
        arguments = [*fast, *new, *ours, *values, *SMOOTHING]
        np.testing.assert_allclose(after, [float(entry) for entry in new], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(force, float(compiled.force(*arguments)[0]), rtol=1e-12, atol=1e-10)
        np.testing.assert_allclose(energy, float(compiled.energy(*arguments)[0]), rtol=1e-12, atol=1e-10)


@pytest.mark.parametrize("structure", STRUCTURES, ids=name_of)
def test_c_agrees_with_the_scalar_source(structure, tmp_path):
    """C gives the same force, energy and states to 1e-12, over random states, and the derivatives of these."""
    equations = structure.equations_without_rig
    law = Law(structure, sound_values(structure), *SMOOTHING)
    call = compiled_c(structure, tmp_path)
    scalar = executed(law)
    p = [*law.vector(equations), *SMOOTHING]
    rng = random.Random(2)
    for _ in range(50):
        slow = {"A": rng.uniform(0.1, 1.5), "f": rng.uniform(0.5, 8), "T": rng.uniform(300, 600), **FURTHER}
        u = [slow[name] for name in conditions_of(equations)]
        z = [rng.uniform(-100, 100) for _ in equations.states]
        y_previous, y, v = rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-30, 30)
        motion = [y_previous, y, v, 0.001]
        (k,) = call("coefficients", p, u, results=(len(stepping(structure).held),))
        np.testing.assert_allclose(k, scalar["coefficients"](*u), rtol=1e-12)
        result, after = call("step", k, z, motion, results=(2, len(z)))
        force, energy, expected = scalar["step"](tuple(k), tuple(z), *motion)
        np.testing.assert_allclose(after, expected, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(result, [force, energy], rtol=1e-12, atol=1e-10)

        def result_at(place, z=z, y_previous=y_previous):
            y, v, *u = place.tolist()
            return np.array(scalar["step"](scalar["coefficients"](*u), tuple(z), y_previous, y, v, 0.001)[:2])

        place = np.array([y, v, *u])
        (slopes,) = call("slopes", p, u, z, motion, results=(2 * len(place),))
        for index, width in enumerate(1e-6 * np.array([1.0, 10.0, *u])):
            aside = width * np.eye(len(place))[index]
            ahead, here, behind = (result_at(place + sign * aside) for sign in (1, 0, -1))
            numeric = (ahead - behind) / (2 * width)
            kink = np.abs(ahead - 2 * here + behind) / width  # across one, the slope of either side will do
            rounding = 1e-15 * np.abs(here) / width
            exact = np.array(slopes).reshape(2, -1)[:, index]
            assert (np.abs(exact - numeric) <= 1e-5 * np.abs(numeric) + 1e-6 + kink + 10 * rounding).all()


@pytest.mark.parametrize("structure", STRUCTURES, ids=name_of)
def test_derivatives_are_exact(structure):
    equations = structure.equations
    base = sound_values(structure)
    vector = np.array([base[name] for name in equations.names])
    motion = sines([0.2, 0.5, 1.0], [1.0, 3.0, 5.0], [300.0, 450.0, 570.0], samples=64)
    response = force_of_equations(equations, vector, SMOOTHING, motion, derivatives=True)
    steady, exact = response.force, response.jacobian.of(np.arange(len(vector)))
    assert exact is not None
    for index, name in enumerate(equations.names):
        width = 1e-6 * max(abs(vector[index]), 1e-2)
        above, below = vector.copy(), vector.copy()
        above[index] += width
        below[index] -= width
        numeric = (
            force_of_equations(equations, above, SMOOTHING, motion).force
            - force_of_equations(equations, below, SMOOTHING, motion).force
        ) / (2 * width)
        rounding = 1e-15 * np.max(np.abs(steady)) / width
        assert np.max(np.abs(exact[index] - numeric)) < 2e-5 * np.max(np.abs(numeric)) + rounding, name


WITH_MEMORY = [name for name in ON_A_BASE if WITH_DECLARED.effect(name).states]


@pytest.mark.parametrize("name", [name for name in WITH_MEMORY if name != "play"])
def test_derivatives_have_values_behind_a_play(name):
    """Where a clearance stands open, the clamp behind it stands still."""
    require_values_at_rest(on_a_bare_law(name, "play"))


def test_derivatives_of_effects_without_memory_have_values_behind_a_play():
    """As many in one law as go together: what has no value, no other term takes away."""
    together = []
    for name in ON_A_BASE:
        if name not in WITH_MEMORY:
            group = next((group for group in together if go_together(*group, name)), None)
            if group is None:
                together.append([name])
            else:
                group.append(name)
    for group in together:
        require_values_at_rest(on_a_bare_law(*group, "play"))


def go_together(*names):
    """Tell whether effects can be in one law."""
    try:
        on_a_bare_law(*names, "play").refuse_misfits()
    except UserError:
        return False
    return True


def require_values_at_rest(structure):
    """Require a force and its derivatives where the law stands still, and where it moves."""
    values = sound_values(structure)
    vector = [values[name] for name in structure.equations.names]
    motion = sines([0.02, 0.5, 1.0], [0.2, 3.0, 5.0], [300.0, 450.0, 570.0], samples=64)
    response = force_of_equations(structure.equations, vector, SMOOTHING, motion, derivatives=True)
    assert np.isfinite(response.force).all()
    assert np.isfinite(response.jacobian.of(np.arange(len(vector)))).all()


def test_a_motion_that_a_law_has_no_values_for_leaves_the_others_alone():
    structure = Structure("power", ("memory",))
    values = sound_values(structure) | {"alpha_f": 2.0}
    vector = [values[name] for name in structure.equations.names]
    with np.errstate(all="ignore"):
        both = force_of_equations(structure.equations, vector, SMOOTHING, sines([0.5, 0.5], [1e3, 3.0], [450.0, 450.0]))
    alone = force_of_equations(structure.equations, vector, SMOOTHING, sines([0.5], [3.0], [450.0]))
    assert not np.isfinite(both.force[0]).all()
    np.testing.assert_array_equal(both.force[1], alone.force[0])


@pytest.mark.parametrize("structure", STRUCTURES, ids=name_of)
def test_stored_energy_is_the_forces_own(structure):
    """Along a slow straight move without slip, the work done is the energy stored plus what is dissipated, >= 0."""
    law = Law(structure, sound_values(structure), *SMOOTHING)
    scope = executed(law)
    k = scope["coefficients"](0.8, 3.0, 450.0, *(FURTHER[name] for name in scope["CONDITIONS"]))
    state = tuple(start for _, start in scope["STATES"])
    count, h = 4000, 1 / (3.0 * 4000)
    force, energy, state = scope["step"](k, state, 0.0, 0.0, 0.0, h)
    y_previous, lost = 0.0, 0.0
    for index in range(1, 2 * count + 1):
        phase = 2 * math.pi * index / count
        y, v = 0.8 * math.sin(phase), 0.8 * 6 * math.pi * math.cos(phase)
        new_force, new_energy, state = scope["step"](k, state, y_previous, y, v, h)
        step_lost = (force + new_force) / 2 * (y - y_previous) - (new_energy - energy)
        lost += step_lost
        assert step_lost > -1e-3, f"energy made from nothing at phase {phase:.3f}"
        force, energy, y_previous = new_force, new_energy, y
    assert lost > 0


@pytest.mark.parametrize("structure", STRUCTURES, ids=name_of)
def test_force_and_energy_have_values_at_the_bounds(structure):
    """A fit may come to rest on a bound."""
    values = sound_values(structure)
    for parameter in structure.equations_without_rig.composed.parameters:
        for bound in (parameter.lower, parameter.upper):
            at_bound = float(sp.sympify(bound).subs(SCALES))
            if not math.isfinite(at_bound) or parameter.name in structure.held():
                continue
            scope = executed(Law(structure, values | {parameter.name: at_bound}, *SMOOTHING))
            k = scope["coefficients"](0.8, 3.0, 450.0, *(FURTHER[name] for name in scope["CONDITIONS"]))
            force, energy, _ = scope["step"](k, tuple(start for _, start in scope["STATES"]), 0.0, 0.3, 12.0, 1e-3)
            assert math.isfinite(force), (parameter.name, at_bound)
            assert math.isfinite(energy), (parameter.name, at_bound)


@pytest.mark.parametrize("structure", STRUCTURES, ids=name_of)
def test_a_record_becomes_its_steady_cycle(structure):
    """Marching a record from rest ends in the periodic response that is found directly, but for the samples at
    reversals, which stand for the mean over their interval in a cycle. A record's delay is straight between samples."""
    equations = structure.equations
    values = sound_values(structure)
    vector = [values[name] for name in equations.names]
    one = sines([0.8], [3.0], [450.0], samples=128)
    cycles = CYCLES_TO_FORGET.get(structure.effects, 30)
    slow = dict(one.slow)
    many = Motion(*(np.tile(signal, cycles) for signal in (one.y, one.v, one.a)), slow, one.h, periodic=False)
    steady = force_of_equations(equations, vector, SMOOTHING, one).force
    record = force_of_equations(equations, vector, SMOOTHING, many).force[:, -128:]
    moving = np.abs(one.v) > 1e-6
    rtol, atol = (1e-9, 1e-6) if not equations.outline.late else (0.0, 3e-3 * np.max(np.abs(steady)))
    np.testing.assert_allclose(record[moving], steady[moving], rtol=rtol, atol=atol)


@pytest.mark.parametrize("name", ON_A_BASE)
def test_a_terms_force_is_in_proportion_to_its_forces_stiffnesses_and_masses(name):
    """So starts are made as large as tests ask, and linearised there, by one evaluation."""
    structure = on_a_bare_law(name)
    equations = structure.equations
    effect = structure.effect(name)
    sizes = [each.name for each in effect.parameters if grows_with_force(each.unit)]
    shapes = [each.name for each in effect.parameters if each.name not in sizes]
    if not sizes or not shapes or effect.scales:  # shapes of what it scales aren't its own force's
        return
    motion = sines([0.3, 0.6, 1.0], [1.0, 3.0, 5.0], [20.0, 150.0, 300.0])
    values = sound_values(structure)

    def law_at(at):
        return force_of_equations(
            equations, [at[each] for each in equations.names], SMOOTHING, motion, derivatives=True
        )

    def slopes(found, names):
        return found.jacobian.of(np.array([equations.names.index(each) for each in names]))

    once, thrice = law_at(values), law_at(values | {each: 3.0 * values[each] for each in sizes})
    own = sum(values[each] * slope for each, slope in zip(sizes, slopes(once, sizes), strict=True))
    scale = np.max(np.abs(once.force))
    np.testing.assert_allclose(thrice.force, once.force + 2.0 * own, atol=1e-6 * scale)
    np.testing.assert_allclose(
        slopes(thrice, shapes), 3.0 * slopes(once, shapes), rtol=1e-5, atol=1e-6 * np.max(np.abs(slopes(once, shapes)))
    )


@pytest.mark.parametrize("name", COPIES)
def test_a_declared_copy_is_the_catalogues_effect(name):
    """Force and derivatives along motions, to 1e-12 of the force; bounds and starts as stated in the catalogue."""
    ours = replace(WITH_DECLARED, effects=(name,))
    theirs = Structure("power", (name.removesuffix("_copy"),))
    motion = sines([0.2, 0.5, 1.0], [1.0, 3.0, 5.0], [300.0, 450.0, 570.0], samples=64)
    values = sound_values(ours)
    both = [
        force_of_equations(
            equations, [values[parameter] for parameter in equations.names], SMOOTHING, motion, derivatives=True
        )
        for equations in (ours.equations, theirs.equations)
    ]
    scale = np.max(np.abs(both[0].force))
    np.testing.assert_allclose(both[0].force, both[1].force, rtol=1e-12, atol=1e-12 * scale)
    slopes = [one.jacobian.of(np.arange(len(values))) for one in both]
    np.testing.assert_allclose(*slopes, rtol=1e-12, atol=1e-10 * scale)
    for mine, original in zip(ours.effect(name).parameters, theirs.effect(theirs.effects[0]).parameters, strict=True):
        for what in ("lower", "upper", "starts"):
            pair = [np.atleast_1d(getattr(parameter, what)) for parameter in (mine, original)]
            one, other = ([float(sp.sympify(value).subs(SCALES)) for value in values] for values in pair)
            np.testing.assert_allclose(*np.broadcast_arrays(one, other), rtol=1e-12)
        assert (mine.name, mine.neutral, mine.levels) == (original.name, original.neutral, original.levels)
