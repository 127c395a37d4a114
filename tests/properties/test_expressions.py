"""The grammar of users' expressions: the same values as NumPy, and nothing but a refusal for any text."""

import string
import subprocess
import sys
import threading
import time
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.time_limit import time_limit
from pipeclamp_models.law.expression import FUNCTIONS, MOST_CHARACTERS, MOST_LEVELS, WHERE, parse_expression
from pipeclamp_models.realise.scalar import ScalarPrinter

NAMES = {name: sp.Symbol(name, real=True) for name in ("y", "v", "p_1")}
POINTS = {"y": np.array([-1.625, -0.375, 0.0, 0.75, 2.5]), "v": np.linspace(-3, 4, 5), "p_1": np.full(5, 0.8125)}
NUMPY = {
    "abs": np.abs, "sign": np.sign, "exp": np.exp, "log": np.log, "sqrt": np.sqrt, "sin": np.sin, "cos": np.cos,
    "tanh": np.tanh, "where": np.where, "pi": np.pi,
    "min": lambda *values: np.min(np.broadcast_arrays(*values), axis=0),
    "max": lambda *values: np.max(np.broadcast_arrays(*values), axis=0),
}  # fmt: skip


def compound(inner):
    pair = st.tuples(inner, inner)
    several = st.lists(inner, min_size=2, max_size=3).map(", ".join)
    single = st.sampled_from([name for name, function in FUNCTIONS.items() if 1 in function.arguments])
    return st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda parts: "({} {} {})".format(*parts)),
        st.tuples(inner, st.sampled_from(["2", "3", "-1", "0.5"])).map(lambda parts: "({}) ** {}".format(*parts)),
        inner.map(lambda text: f"-{text}"),
        st.tuples(single, inner).map(lambda parts: "{}({})".format(*parts)),
        st.tuples(st.sampled_from(["min", "max"]), several).map(lambda parts: "{}({})".format(*parts)),
        st.tuples(inner, st.sampled_from(["<", "<=", ">", ">="]), inner, pair).map(
            lambda parts: f"where({parts[0]} {parts[1]} {parts[2]}, {parts[3][0]}, {parts[3][1]})"
        ),
    )


expressions = st.recursive(st.sampled_from(["y", "v", "p_1", "0.5", "2.0", "1.25", "pi"]), compound, max_leaves=8)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(expressions)
def test_an_expression_has_numpys_values(text):
    try:
        expression = parse_expression(text, NAMES, "force")
    except UserError as error:
        assert any(words in str(error) for words in ("real value", "divides by zero", "within a comparison"))
        return
    with np.errstate(all="ignore"):
        expected = np.broadcast_to(np.asarray(eval(text, dict(NUMPY), POINTS), dtype=float), 5)
        compiled = sp.lambdify(list(NAMES.values()), expression, "numpy")
        found = np.broadcast_to(np.asarray(compiled(*(POINTS[name] for name in NAMES)), dtype=float), 5)
    sound = np.isfinite(expected) & np.isfinite(found) & (np.abs(expected) < 1e6)
    np.testing.assert_allclose(found[sound], expected[sound], rtol=1e-9, atol=1e-9)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(expressions)
def test_an_expression_has_derivatives_that_numpy_can_work_out(text):
    from pipeclamp_models.realise.array_source import _nonzero_slopes, _source
    from pipeclamp_models.realise.arrays import NUMPY

    try:
        expression = parse_expression(text, NAMES, "force")
    except UserError:
        return
    _, slopes = _nonzero_slopes([expression], list(NAMES.values()))
    defined: dict[str, Any] = {}
    exec(_source(list(NAMES.values()), slopes), dict(NUMPY), defined)
    (compiled,) = defined.values()
    with np.errstate(all="ignore"):
        values = compiled(*(POINTS[name] for name in NAMES))
    assert all(np.asarray(value).dtype.kind in "fi" for value in values)
    assert isinstance(ScalarPrinter({"fully_qualified_modules": True}).doprint(expression), str)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(expressions)
@example("where(v > 0.5, cos(y) ** 3, tanh(p_1 * y)) + abs(v) ** 1.5 / (2 + sin(y)) - log(abs(y) + 1) * exp(-v)")
@example("min(y, v, 0.5) * max(v, 1) + sqrt(abs(v)) + sign(y) * abs(y) ** p_1 + y ** 7 / v ** 2 - p_1 ** v")
def test_machine_code_has_numpys_values_and_slopes(text):
    from pipeclamp_models.realise.array_source import _nonzero_slopes
    from pipeclamp_models.realise.marches import course_source, slopes_source, walk_source
    from pipeclamp_models.realise.walks import Course, StepSlopes, Taken, Walk

    try:
        expression = parse_expression(text, NAMES, "force")
    except UserError:
        return
    names, through = list(NAMES.values()), sp.Symbol("through", real=True)
    off_kinks = [POINTS["y"] + np.sqrt(2) / 100, POINTS["v"] + np.sqrt(3) / 100, POINTS["p_1"]]
    taken, rest = Taken([values[:, None] for values in off_kinks], (5, 1)), np.zeros((1, 5))
    walk = Walk([0], range(3), walk_source(names, [through], [expression], []))
    source, index = slopes_source(names, names, [2 * through], [(through, expression)])
    slopes = dict(zip(index, StepSlopes(len(index), range(3), source)(taken), strict=True))
    source, index = course_source(names, [through], [expression], [], names)
    along = Course([0], range(3), index, source)(rest, taken)
    pairs = [(walk(rest, taken)[0], expression), (along.states[0], expression)]
    for (_, column), slope in zip(*_nonzero_slopes([expression], names), strict=True):
        pairs.append((slopes.get((0, column), np.zeros((5, 1))), 2 * slope))
        pairs.append((along.slopes.get((0, 1 + column), np.zeros((5, 1))), slope))
    for ours, theirs in pairs:
        with np.errstate(all="ignore"):
            values = sp.lambdify(names, theirs, "numpy")(*off_kinks)
        numbers = np.broadcast_to(np.asarray(values, dtype=float), 5)
        sound = np.isfinite(numbers) & np.isfinite(ours[:, 0]) & (np.abs(numbers) < 1e6)
        np.testing.assert_allclose(ours[sound, 0], numbers[sound], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 3.0])
def test_machine_code_has_the_slope_of_a_power_where_its_base_vanishes(exponent):
    from pipeclamp_models.realise.marches import slopes_source
    from pipeclamp_models.realise.walks import StepSlopes, Taken

    base, power = NAMES["y"], NAMES["p_1"]
    source, index = slopes_source([base, power], [base, power], [base**power], [])
    bases = np.array([0.0, 0.25, -0.0])
    slopes = StepSlopes(len(index), range(2), source)(Taken([bases[:, None], np.full((3, 1), exponent)], (3, 1)))
    with np.errstate(divide="ignore"):
        expected = exponent * np.abs(bases) ** (exponent - 1)
    np.testing.assert_allclose(dict(zip(index, slopes, strict=True))[0, 0][:, 0], expected, rtol=1e-14)


ALPHABET = string.ascii_letters + string.digits + "+-*/()., <>=_\n\t\"'[]{}:;#\\@!%^&|~äλ\x00"
TOKENS = [
    "y",
    "v",
    "(",
    ")",
    "+",
    "-",
    "*",
    "/",
    "**",
    ",",
    "<",
    ">=",
    "where(",
    "exp(",
    "max(",
    "1e9",
    "9",
    "lambda",
    " ",
]


@settings(max_examples=300, deadline=20_000, derandomize=True)
@given(
    st.one_of(
        st.text(max_size=60),
        st.text(ALPHABET, max_size=60),
        st.lists(st.sampled_from(TOKENS), max_size=25).map("".join),
    )
)
@example("\ud800")
def test_any_text_is_an_expression_or_refused(text):
    try:
        assert isinstance(parse_expression(text, NAMES, "force"), sp.Expr)
    except UserError as error:
        assert str(error).startswith("force")


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("", None, "is empty"),
        ("y +", None, "is no expression"),
        ("2 * vv", 5, "did you mean 'v'?"),
        ("expp(y)", 1, "did you mean 'exp'?"),
        ("exp", 1, "expected exp(...)"),
        ("exp(y, v)", 1, "2 arguments; expected 1"),
        ("y ^ 2", 1, "expected ** for a power"),
        ("y < v", 1, "stands only first in where"),
        ("where(y, 1, 2)", 1, "expected where(comparison, a, b)"),
        ("where(0 < y < 1, 1, 2)", 1, "one of < <= > >="),
        ("where(where(y > 0, 1, v) > 0, 1, 2)", 1, "holds a choice"),
        ("abs(log(abs(log(y))))", 1, "holds a choice"),
        ("where(y == v, 1, 2)", 1, "one of < <= > >="),
        ("max(y)", 1, "expected 2 to 8"),
        ("max(y, key=v)", 1, "not of the grammar"),
        ("max(*y)", 5, "not of the grammar"),
        ("y / 0", 1, "divides by zero"),
        ("y / (1 - 1)", 1, "divides by zero"),
        ("y + sqrt(-2)", 5, "no real value"),
        ("y + log(0)", 5, "no real value"),
        ("(-8) ** 0.5", 1, "no real value"),
        ("sqrt(-y**2)", 1, "no real value"),
        ("9**9**9", 1, "exponent 3.8742e+08; expected 100 at most"),
        ("9.0**99 * 9.0**99", 1, "number above"),
        ("y**9**9", 1, "exponent"),
        ("y**1000", 1, "exponent 1000; expected 100 at most"),
        ("(2*y)**1e9", 1, "exponent"),
        ("(((2*y)**100)**100)**100", None, "number above"),
        ("exp(exp(exp(9)))", 5, "too large"),
        ("1e999", 1, "real value"),
        ("9" * 400, 1, "too large"),
        ("1e-200 * y", 1, "number above"),
        ("y * 1e90 * v * 1e90", 1, "number above"),
        ("y" * (MOST_CHARACTERS + 1), None, f"expected {MOST_CHARACTERS} at most"),
        ("(" * 500 + "y" + ")" * 500, None, "is no expression"),
        ("-" * 1500 + "y", None, "nested too deep"),
        ("abs(sin(" * MOST_LEVELS + "y" + "))" * MOST_LEVELS, None, "nested too deep"),
        ("__import__('os').system('echo')", 1, "not of the grammar"),
        ("y.__class__", 1, "not of the grammar"),
        ("(lambda: y)()", 1, "not of the grammar"),
        ("[y for y in v]", 1, "not of the grammar"),
        ("y if v else 1", 1, "not of the grammar"),
        ("(y := v)", 2, "not of the grammar"),
        ("True", 1, "not of the grammar"),
        ("1j", 1, "not of the grammar"),
        ("'y'", 1, "not of the grammar"),
        ("y; v", 2, "no character"),
        ("y # v", 3, "no character"),
        ("λ * y", 1, "name 'λ' is not known"),
        ("y + größe", 5, "name 'größe' is not known"),
        ("where(größe > 0, y, q)", 7, "name 'größe' is not known"),
        ("2 € * y", 3, "no character"),
        ("y²", 2, "no character"),
    ],
)
def test_what_is_refused_says_where_and_why(text, place, words):
    with pytest.raises(UserError) as refused:
        parse_expression(text, NAMES, "force")
    assert words in str(refused.value)
    if place is not None:
        assert f"character {place}:" in str(refused.value)


def test_a_text_of_several_lines_is_one_expression():
    assert parse_expression("\n  2 * y\n  + v\n", NAMES, "force") == 2 * NAMES["y"] + NAMES["v"]


def test_the_longest_texts_are_read_in_a_moment():
    """The worst of what the limits allow: many branches, and many extremes, inside one another."""
    extremes = " + ".join(f"max(y - {number}, v, p_1)" for number in range(80))
    chosen = "y"
    for number in range(MOST_LEVELS - 2):
        chosen = f"where(y>{number},{chosen},v)"
    wide = " + ".join(f"where(abs(y+{number})>v, abs(log(v)), p_1)" for number in range(30))
    for text in (extremes, chosen, wide, "max(" * 90 + "y" + ", v)" * 90, "*".join(["(y + v)"] * 99)):
        assert len(text) <= MOST_CHARACTERS
        begin = time.process_time()
        parse_expression(text, NAMES, "force")
        assert time.process_time() - begin < 5
    assert {*FUNCTIONS, WHERE} == set(NUMPY) - {"pi"}


def test_a_stopped_computation_leaves_nothing_behind():
    """CPython 3.11 hung under a tracer where an exception on its way had been taken back."""
    script = (
        "import sys\n"
        "from pipeclamp_models.base.time_limit import time_limit\n"
        "try:\n"
        "    with time_limit(0.05, ValueError('too long')):\n"
        "        while True: pass\n"
        "except ValueError as error:\n"
        "    sys.settrace(lambda *event: None)\n"
        "    print((lambda: error)())\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "too long\n"


def test_a_computation_that_ends_as_its_time_does_is_stopped_or_not_at_all():
    """Nothing is raised later, whenever the end comes."""
    for share in np.linspace(0.5, 1.5, 60):
        end = time.monotonic() + 0.004 * share
        with suppress(UserError), time_limit(0.004, UserError("too long")):
            while time.monotonic() < end:
                pass


def test_time_that_is_over_before_the_computation_begins_is_told_alike(monkeypatch):
    """As on a busy machine, where the clock that stops it takes longer to start than the time that is given."""
    start = threading.Timer.start

    def slowly(timer):
        start(timer)
        until = time.monotonic() + 1.0
        while time.monotonic() < until:
            pass

    monkeypatch.setattr(threading.Timer, "start", slowly)
    with pytest.raises(UserError, match="too long"), time_limit(0.004, UserError("too long")):
        pytest.fail("it began")


def test_a_computation_without_end_is_stopped():
    begin = time.monotonic()
    with pytest.raises(UserError, match="too long"), time_limit(0.05, UserError("too long")):
        while True:
            with suppress(Exception):
                sum(range(1000))
    assert time.monotonic() - begin < 5
    with time_limit(60, UserError("never")):
        assert sum(range(1000)) == 499500
