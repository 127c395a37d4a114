"""What comes after a system was computed follows what was found, and its line can be run as it stands."""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import polars as pl
import pytest
from banded import banded
from typer.main import get_command

from pipeclamp.cli.app import app
from pipeclamp_identification.workflow.next_built import after_packaging
from pipeclamp_identification.workflow.systems.next_in_system import after_cosim, after_response, after_sweep
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_system.steady.states import FollowedResponse


@dataclass
class Result:
    """A co-simulation as far as it decides what comes next."""

    trusted: bool = True
    unsettled: dict = field(default_factory=dict)
    mistaken: tuple = ()
    out_of_range: tuple = ()

    def remedy(self):
        return "with step_s = 0.0005 or less"

    @property
    def time(self):
        return np.linspace(0, 1, 2001)

    @property
    def columns(self):
        angle = 2 * np.pi * 20 * self.time
        return {"clamp1.s": 4e-3 * np.sin(angle), "clamp1.v": 4e-3 * 2 * np.pi * 20 * np.cos(angle)}

    @property
    def system(self):
        return SimpleNamespace(clamps=[SimpleNamespace(at="clamp1", temperature_C=320.0)])


@dataclass
class Response:
    """A frequency response likewise."""

    doubtful_dots: tuple = ()
    left_out: bool = False
    stated_harmonics: bool = False
    whole: bool = True
    unbounded: bool = False
    beyond: dict = field(default_factory=dict)
    clamp_names: tuple = ("clamp1",)

    @property
    def curves(self):
        state = SimpleNamespace(beyond=(self.beyond,), unbounded=self.unbounded, frequency=5.0)
        return [SimpleNamespace(followed=FollowedResponse(((state,),), whole=self.whole), states=[state])]


def can_be_run(line):
    name, *words = shlex.split(line)[1:]
    get_command(app).commands[name].make_context(name, words, resilient_parsing=True)


def said(step):
    can_be_run(step.line)
    return step.words()


AS_FAR = "Next, to test as far as clamp1 moves: pipeclamp plan -o planned --law "
COSIM = {
    "not to be trusted": (Result(trusted=False), "Next, with step_s = 0.0005 or less: pipeclamp cosim S -o c.csv"),
    "not settled": (Result(unsettled={"tip": 0.1}), "Next, with a larger stop_s: pipeclamp cosim S -o c.csv"),
    "another A": (Result(mistaken=("clamp1",)), "Next, with solve = true at clamp1: pipeclamp cosim S -o c.csv"),
    "beyond the data": (Result(out_of_range=("clamp1",)), f"{AS_FAR}L --limits A=0.2..4,f=1..20,T=20..320"),
    "all right": (Result(), "Next: pipeclamp response S -o response.csv --report response.html"),
}
RESPONSE = {
    "dots in doubt": (
        Response(doubtful_dots=(1,)),
        "Next, with a smaller step_s or scheme = 'implicit': pipeclamp response S -o r.csv",
    ),
    "harmonics that were stated": (
        Response(left_out=True, stated_harmonics=True),
        "Next, without harmonics in [response]: pipeclamp response S -o r.csv",
    ),
    "a force that steps": (
        Response(left_out=True),
        "Next, with a frequency where it is in doubt: pipeclamp cosim S -o cosim.csv",
    ),
    "not bounded": (
        Response(whole=False, unbounded=True),
        "Next, with the pipe's damping in its file, or a law with damping: pipeclamp response S -o r.csv",
    ),
    "given up": (Response(whole=False), "Next, with other ends of [response]: pipeclamp response S -o r.csv"),
    "beyond the data": (
        Response(beyond={"A": 0.01, "T": 400.0 + CELSIUS}),
        f"{AS_FAR}L --limits A=0.01..1,f=1..5,T=20..400",
    ),
    "all right": (Response(), "Next: pipeclamp response S -o r.csv --bands 95"),
}


def told(line, path):
    return line.replace(" S", f" {path}").replace(" L ", f" {path.parent / 'law.json'} ")


@pytest.mark.parametrize("case", COSIM)
def test_after_a_co_simulation(tmp_path, case):
    path = banded(tmp_path, 1.0)
    result, line = COSIM[case]
    assert said(after_cosim(result, path, "c.csv")) == told(line, path)


@pytest.mark.parametrize("case", RESPONSE)
def test_after_a_response(tmp_path, case):
    path = banded(tmp_path, 1.0)
    found, line = RESPONSE[case]
    assert said(after_response(found, path, "r.csv")) == told(line, path)


def test_a_plan_beyond_the_tests_asks_for_whole_degrees(tmp_path):
    """Laws' files hold whole kelvins, about those of the tests: 20 degC is 293 to 294 K there."""
    path = banded(tmp_path, 1.0)
    law = json.loads((tmp_path / "law.json").read_text(encoding="utf-8"))
    law["range"]["T"] |= {"minimum": 293.0, "maximum": 334.0}
    (tmp_path / "law.json").write_text(json.dumps(law), encoding="utf-8")
    assert said(after_response(Response(beyond={"A": 0.01}), path, "r.csv")).endswith(",T=20..60")


def test_where_it_is_known_how_sure_it_is_a_test_is_planned(tmp_path):
    path = banded(tmp_path, 1.0)
    assert said(after_response(Response(), path, "r.csv", bands=95.0)) == f"Next: pipeclamp plan {path}"


def test_what_no_law_tells_isnt_asked(tmp_path):
    path = banded(tmp_path, 1.0)
    path.write_text(path.read_text(encoding="utf-8").replace("law.json", "emwm2"), encoding="utf-8")
    assert said(after_response(Response(), path, "r.csv")) == f"Next: pipeclamp system {path} -o system.ssp"


@pytest.mark.parametrize(
    ("measure", "columns", "line"),
    [
        ("steady", {"error": ["", "no steady state"]}, "Next, once the 1 cases without a result"),
        ("cosim", {"error": ["", ""], "trusted": [True, False]}, "Next, with a smaller step_s: pipeclamp sweep"),
        ("cosim", {"error": ["", ""], "trusted": [True, True]}, "Next, with the case that you choose: pipeclamp cosim"),
        ("peak", {"error": ["", ""]}, "Next, with the case that you choose: pipeclamp response"),
    ],
)
def test_after_a_study(tmp_path, measure, columns, line):
    study = SimpleNamespace(description=SimpleNamespace(system="my system.toml", measure=measure))
    step = after_sweep(study, pl.DataFrame(columns), tmp_path / "study.toml", "s.parquet")
    assert said(step).startswith(line)
    if "sweep" not in step.line:
        assert f'"{tmp_path / "my system.toml"}"' in step.line


def test_after_a_system_was_packaged(tmp_path):
    can_be_run(after_packaging(str(tmp_path / "system.toml")))
