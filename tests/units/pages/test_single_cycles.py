"""Campaigns whose runs hold one cycle each show no scatter: what is said of noise says which noise is meant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeclamp.pages.diagnosis import diagnosis_answer, evidence_sections
from pipeclamp.show.diagnosis import diagnosis_view
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed, diagnosed
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_models.law.file import Provenance

SINGLE, SEVERAL = 1, 2


@pytest.fixture(scope="module", params=[SINGLE, SEVERAL])
def complete(request, tmp_path_factory):
    """The base law diagnosed on six runs of a clamp that is no more, and whether they hold one cycle each."""
    rng, runs = np.random.default_rng(3), []
    for amplitude in (0.4, 0.8, 1.2):
        for frequency in (1.0, 3.0):
            time = np.arange(200 * request.param) / 200 / frequency
            omega = 2 * np.pi * frequency
            y, v = amplitude * np.sin(omega * time), amplitude * omega * np.cos(omega * time)
            force = 900 * y + 30 * y**3 + 20 * np.abs(v) ** 0.5 * np.sign(v) + rng.normal(0, 2, len(time))
            runs.append(
                WrittenRun({"run": f"A{amplitude}_f{frequency:g}", "temperature_C": 20.0}, Record(time, y, force))
            )
    folder = tmp_path_factory.mktemp("c") / "c"
    write_campaign(folder, iter(runs), name="c", notes="")
    campaign = read_campaign(folder)
    return diagnosed(
        law_file(identify(campaign), campaign, name="law", provenance=Provenance("test")), campaign
    ), request.param == SINGLE


def told(found):
    """Give what the terminal says, what the page says, and the answer as JSON has it."""
    view = diagnosis_view(found, (), "", None)
    page = [*diagnosis_answer(found).paragraphs, *evidence_sections(found)[-1].paragraphs]
    return " ".join(view.lines), " ".join(page), view.answer.model_dump()


def test_what_a_complete_law_leaves_is_scatter_only_where_cycles_show_any(complete):
    found, single = complete
    assert found.verdict == "complete"
    terminal, page, answer = told(found)
    rest = "noise within a cycle" if single else "scatter"
    assert all(f"Complete: what is left is {rest}." in text for text in (terminal, page))
    assert answer["noise_of"] == ("samples" if single else "cycles")


def test_multiples_of_noise_say_which_noise_is_meant(complete):
    found, single = complete
    lack = replace(found.diagnosis.law.lack, share=1.3, p_value=0.0)
    unknown = replace(found.diagnosis.found, verdict="unknown")
    diagnosis = replace(found.diagnosis, law=replace(found.diagnosis.law, lack=lack), found=unknown)
    terminal, page, answer = told(replace(found, diagnosis=diagnosis))
    times = "1.3 times the noise within a cycle" if single else "1.3 times the noise"
    for text in (terminal, page, *answer["left_over"][:1]):
        assert times in text and ("within a cycle" in text) == single
    for text in (terminal, page, " ".join(answer["reasons"])):
        assert ("the noise meant is that between the samples of a cycle" in text) == single


def test_the_page_says_of_a_complete_law_what_the_terminal_says(complete, monkeypatch):
    """Once the page left out that nothing shows what a law does between three levels of a bolt's torque."""
    monkeypatch.setattr(RecordDiagnosed, "few_levels", lambda found: ("three levels of torque",))
    monkeypatch.setattr(RecordDiagnosed, "other_values", lambda found: ("on other values",))
    terminal, page, _ = told(complete[0])
    for words in ("three levels of torque", "on other values"):
        assert words in terminal
        assert sentence(words) in page
