"""The page inside an FMU shows how its law came about: the error step by step, and how well it fits."""

import re

import pytest

from pipeclamp_fmu.contents.clamp import clamp_documentation, quantities
from pipeclamp_fmu.contents.clamp_of_law import clamp_model
from pipeclamp_fmu.describe.documentation import page
from pipeclamp_fmu.describe.history import HEADING, history_section
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import FitQuality, HistoryStep, RunQuality

FIT = FitQuality(
    method="joint",
    nrmse=0.005,
    noise_nrmse=0.004,
    runs=(RunQuality(run="slow", nrmse=0.004), RunQuality(run="<hot>", nrmse=0.0123)),
)
STEPS = (
    HistoryStep(step="power", nrmse=0.03, refitted_nrmse=0.04),
    HistoryStep(step="+ memory", nrmse=0.01, refitted_nrmse=0.02),
    HistoryStep(step="- memory", nrmse=0.029, refitted_nrmse=0.03),
)


def test_a_step_of_an_older_file_is_read_and_written_under_the_name_of_today():
    step = HistoryStep.model_validate({"step": "power", "nrmse": 0.03, "heldout_nrmse": 0.04})
    assert step.model_dump(exclude_none=True) == {"step": "power", "nrmse": 0.03, "refitted_nrmse": 0.04}


def test_a_waterfall_starts_where_the_step_before_ended():
    bars = history_section(STEPS, FIT).bars
    assert [(bar.label, bar.before, bar.level) for bar in bars.rows] == [
        ("power", 1.0, 1.0), ("+ memory", 1.0, 0.5), ("- memory", 0.5, pytest.approx(0.75)),
    ]  # fmt: skip
    assert bars.mark == pytest.approx(0.1)
    assert "left-out conditions" in bars.caption


def test_where_a_step_states_no_error_on_left_out_conditions_that_on_the_runs_used_is_shown():
    section = history_section((*STEPS, HistoryStep(step="+ gap", nrmse=0.015)), None)
    assert [bar.level for bar in section.bars.rows] == pytest.approx([1.0, 1 / 3, 29 / 30, 0.5])
    assert "the runs used" in section.bars.caption
    assert section.bars.mark is None
    assert section.bars.rows[-1].cells[1] == "–"


def test_the_page_draws_it_and_escapes_names():
    text = page("law", (), [history_section(STEPS, FIT)])
    assert re.findall(r'class="(fallen|risen)" style="left: ([\d.]+)%; width: ([\d.]+)%"', text) == [
        ("fallen", "50.00", "50.00"), ("risen", "50.00", "25.00"),
    ]  # fmt: skip
    assert text.count('class="mark" style="left: 10.00%"') == len(STEPS)
    assert "&lt;hot&gt;, with 1.23" in text
    assert "<script" not in text


def test_a_law_without_steps_has_words_alone_and_one_without_either_no_section():
    model = clamp_model(open_law("emwm2").model_copy(update={"history": STEPS, "fit": FIT}))
    assert HEADING in clamp_documentation(model, quantities(model), ())
    assert history_section((), FIT).bars is None
    bare = clamp_model(open_law("published_R1").model_copy(update={"history": (), "fit": None}))
    assert HEADING not in clamp_documentation(bare, quantities(bare), ())
