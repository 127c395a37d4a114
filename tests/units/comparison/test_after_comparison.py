"""What comes after a comparison with so few runs that no diagnosis takes them: a campaign around them."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.diagnosis.thresholds import FEWEST_RUNS
from pipeclamp_identification.workflow.after_comparison import after_comparison


def held(runs, kelvin):
    loops = SimpleNamespace(
        amplitude_mm=np.full(runs, 0.5), frequency_Hz=np.full(runs, 3.0), temperature_K=np.full(runs, kelvin)
    )
    return Comparison(None, SimpleNamespace(time_measured=True), loops, (None,) * runs, {})


@pytest.mark.parametrize(("kelvin", "at"), [(293.15, ",T=20..20"), (float("nan"), "")])
def test_few_runs_call_for_a_campaign_around_them(kelvin, at):
    line = f"pipeclamp plan -o planned --law law.json --limits A=0.25..0.75,f=1.5..6{at}"
    assert after_comparison("law.json", "tests", held(1, kelvin)) == line
    assert after_comparison("law.json", "tests", held(FEWEST_RUNS - 1, kelvin)) == line


def test_as_many_as_a_diagnosis_takes_are_diagnosed():
    assert after_comparison("law.json", "tests", held(FEWEST_RUNS, 293.15)).startswith("pipeclamp diagnose")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("warning: one row", "Warning: one row."),
        ("memory:2 explains it", "memory:2 explains it."),
        ("clamp_a: errs", "clamp_a: errs."),
        ("most of it", "Most of it."),
    ],
)
def test_a_sentence_begins_with_a_capital_but_where_a_name_does(words, told):
    assert sentence(words) == told
