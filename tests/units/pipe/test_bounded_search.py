"""Nothing is followed or sought without end, a path that turns at a kink goes on, and how far it came is told."""

import numpy as np
import pytest
from cantilever import FOUR_METRES

from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.response import run
from pipeclamp_system.response.curves import FrequencyResponse
from pipeclamp_system.response.run import curve_of
from pipeclamp_system.response.summary import response_summary
from pipeclamp_system.steady import detached
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.continuation import Equation, Evaluated, Solution, Steps, Work, follow
from pipeclamp_system.steady.described import ResponseTable


def hardening() -> SteadySystem:
    structure = Structure("power", ())
    known = {"k10": 8.0, "k30": 2.0, "c0": 0.004, "alpha0": 1.0}
    law = Law(structure, {name: known.get(name, 0.0) for name in structure.equations.names}, 1e-6, 1e-6)
    clamp = SteadyClamp(law, 293.15, 1.0, 6.0, (0.01, 9.0), (0.5, 60.0))
    return SteadySystem(reduce(parse_pipe(FOUR_METRES)), [(0, clamp)], lambda frequency: 0.5)


def said_of(table: ResponseTable) -> tuple[str, list[str]]:
    told: list[str] = []
    curve = curve_of(hardening(), table, None, 1.0, "", told.append)
    return response_summary(FrequencyResponse("x", ("c",), (), "", (curve,), (), ({},))), told


def test_a_search_that_takes_too_much_ends_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(detached, "FREQUENCIES_SOUGHT", 3)
    table = ResponseTable(from_Hz=1.5, to_Hz=5.0)
    said, told = said_of(table)
    assert "not sought to the end" not in said
    assert any(one.startswith("followed to") for one in told)
    assert sum(one.startswith("branches apart") for one in told) == 3

    monkeypatch.setattr(run, "MOST_SEARCH", 3000.0)
    monkeypatch.setattr(run, "LEAST_SEARCH", 3000.0)
    said, told = said_of(table)
    assert "further branches were not sought to the end" in said
    assert sum(one.startswith("branches apart") for one in told) < 3


def test_a_path_that_takes_too_much_is_given_up() -> None:
    work = Work()

    def winding(unknowns: np.ndarray, parameter: float) -> Evaluated:
        """A path that winds ever faster: it has no end within any number of steps."""
        work.done += 1
        turn = np.exp(30 * parameter)
        slope = -30 * turn * np.cos(turn)
        return Evaluated(unknowns - np.sin(turn), np.eye(1), np.array([slope]))

    equation, start = Equation(winding, work=work), Solution(0.0, np.array([np.sin(1.0)]))
    *_, last = follow(equation, start, 1.0, 1.0, Steps(work=500))
    assert last.parameter < 1.0
    assert 500 < work.done < 700
    with work.at_most(100):
        *_, last = follow(equation, start, 1.0, 1.0)
        assert work.used_up
    assert last.parameter < 1.0
    assert not work.used_up


def kinked(unknowns: np.ndarray, parameter: float) -> Evaluated:
    """Rise to 0.9 at 0.5 and fall steeply: where a law's A comes into the range in which it is held a path may turn so.

    Seen along the way up, no point of the path lies ahead there.
    """
    slope = 1.8 if unknowns[0] < 0.5 else -5.0
    return Evaluated(0.9 + slope * (unknowns - 0.5) - parameter, np.array([[slope]]), np.array([-1.0]))


def test_a_path_goes_round_a_kink_at_which_it_turns_back() -> None:
    *_, last = follow(Equation(kinked), Solution(0.0, np.zeros(1)), 1.0, 0.5)
    assert last.parameter == 0.0
    assert last.unknowns[0] == pytest.approx(0.5 + 0.9 / 5, abs=1e-6)
