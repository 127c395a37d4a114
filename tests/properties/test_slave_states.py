"""Whatever was done to a slave, a saved state brings it back exactly, and a refused step changes nothing."""

import math
from collections import defaultdict

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stand_in import RANGES, VALUES

from pipeclamp_fmu.contents.clamp import clamp_variables
from pipeclamp_fmu.contents.clamp_model import ClampModel, Entry
from pipeclamp_fmu.describe.model_description import Quantity
from pipeclamp_fmu.describe.variables import numbers_of
from pipeclamp_fmu.slaves.clamp import ClampSlave
from pipeclamp_fmu.slaves.pipe import PipeSlave
from pipeclamp_fmu.slaves.values_file import FILE_NAME, values_text

SLAVES = {"clamp": (ClampSlave, 3, 2, (1e-3, 0.05, 400.0)), "pipe": (PipeSlave, 2, 1, (5.0, 50.0))}

values = st.floats(-2.0, 2.0)
moves = st.lists(
    st.one_of(
        st.tuples(st.just("input"), st.integers(0, 2), values),
        st.tuples(st.just("flag"), st.integers(0, 1), st.booleans()),
        st.tuples(st.just("step"), st.floats(1e-6, 0.1)),
    ),
    max_size=30,
)


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    """Give a function that makes a slave that is initialised."""
    folder = tmp_path_factory.mktemp("resources")
    model = ClampModel("stand-in", "", tuple(Entry(name, "", "", value) for name, value in VALUES.items()), *RANGES)
    variables = clamp_variables(model, defaultdict(lambda: Quantity("")))
    text = values_text("", "stand-in", numbers_of(variables, model.ranges))
    (folder / FILE_NAME).write_text(text, encoding="utf-8")

    def make(kind):
        slave = SLAVES[kind][0](instance_name=kind, resources=str(folder))
        slave.exit_initialization_mode()
        return slave

    return make


def play(slave, kind, sequence):
    """Do the moves and give what each step answered, with all outputs."""
    _, inputs, flags, sizes = SLAVES[kind]
    first_flag, first_fixed = len(slave._reals) + 1, slave._first_fixed
    seen = []
    for move, *arguments in sequence:
        if move == "input":
            vr = arguments[0] % inputs
            slave.set_real([vr + 1], [arguments[1] * sizes[vr]])
        elif move == "flag":
            slave.set_boolean([first_flag + arguments[0] % flags], [arguments[1]])
        else:
            answer = slave.do_step(0.0, arguments[0])
            seen.append((answer, tuple(slave.get_real(list(range(inputs + 1, first_fixed + 1))))))
    return seen


@pytest.mark.parametrize("kind", SLAVES)
@settings(max_examples=60, deadline=None)
@given(before=moves, astray=moves, after=moves)
def test_a_state_comes_back_exactly(fresh, kind, before, astray, after):
    slave, other = fresh(kind), fresh(kind)
    play(slave, kind, before)
    state = slave._get_fmu_state()
    data = slave._fmu_state_to_bytes(state)
    expected = play(slave, kind, after)
    end = slave._get_fmu_state()
    play(slave, kind, astray)
    slave._set_fmu_state(state)
    assert play(slave, kind, after) == expected
    assert slave._get_fmu_state() == end
    play(other, kind, astray)
    other._set_fmu_state(other._fmu_state_from_bytes(data))
    assert play(other, kind, after) == expected
    assert other._get_fmu_state() == end


@pytest.mark.parametrize("kind", SLAVES)
@settings(max_examples=60, deadline=None)
@given(before=moves, bad=st.sampled_from([math.nan, math.inf, -math.inf]), where=st.integers(0, 2), after=moves)
def test_a_refused_step_changes_nothing(fresh, kind, before, bad, where, after):
    slave, twin = fresh(kind), fresh(kind)
    for each in (slave, twin):
        play(each, kind, before)
    vr = 1 + where % SLAVES[kind][1]
    good = slave.get_real([vr])
    slave.set_real([vr], [bad])
    assert not slave.do_step(0.0, 1e-3)
    slave.set_real([vr], good)
    for h in (0.0, -1e-3, bad):
        assert not slave.do_step(0.0, h)
    assert play(slave, kind, after) == play(twin, kind, after)
    assert len(slave.log_queue) >= 4
