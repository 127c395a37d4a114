"""That an addition doesn't help is said in one sentence: on the command line, from Python, and in the studio."""

import numpy as np
import pytest

import pipeclamp as pc
from pipeclamp.show.law import vain_words
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_models.law.file import HistoryStep


def history(*steps):
    return [HistoryStep(step=step, nrmse=0.01, refitted_nrmse=error) for step, error in steps]


def test_the_law_got_worse():
    assert vain_words(history(("power", 0.0499), ("+ memory:2", 0.0749))) == (
        "The law got worse: the error on left-out conditions rises with memory:2 (4.99% -> 7.49%); "
        "keep the law without it"
    )


def test_several_that_were_added_at_once_are_judged_by_the_last():
    way = history(("power", 0.05), ("+ play", 0.06), ("+ delay", 0.0501))
    assert vain_words(way, 2) == (
        "The error on left-out conditions doesn't fall with play and delay (5.00% -> 5.01%); keep the law without them"
    )
    assert vain_words(way) == ""  # with play in the law before, delay helps
    assert vain_words(history(("power", 0.05), ("+ play", 0.06), ("+ delay", 0.01)), 2) == ""


@pytest.mark.parametrize(("few", "error", "worse"), [(True, 0.02, False), (True, 0.0499, True), (None, 0.02, True)])
def test_of_few_settings_left_out_ones_tell_nothing_of_what_fits_better(few, error, worse):
    """Where it doesn't even fit the tests better, the law is to be kept without it all the same."""
    before = HistoryStep(step="power", nrmse=0.05, refitted_nrmse=0.19)
    added = HistoryStep(step="+ condition:current_A", nrmse=error, refitted_nrmse=0.21, few_settings=few)
    words = vain_words([before, added])
    assert words.startswith("The law got worse") == ("keep the law without" in words) == worse
    if not worse:
        assert words.startswith("Left-out conditions can't tell whether condition:current_A helps")
        assert "19.00% -> 21.00%, that on the runs used 5.00% -> 2.00%; test at more levels" in words


@pytest.mark.parametrize(("currents", "few"), [((0.5, 2.0), True), ((0.5, 1.0, 2.0), False)])
def test_an_addition_at_four_settings_is_not_called_worse(tmp_path, currents, few):
    """Two frequencies and two currents, of which one damps at one frequency alone: "got worse" had been said."""
    rng, runs = np.random.default_rng(5), []
    for f in (1.0, 3.0):
        for current in currents:
            t = np.arange(600) / 200 / f
            y, v = np.sin(2 * np.pi * f * t), 2 * np.pi * f * np.cos(2 * np.pi * f * t)
            force = 300 * y + 30 * np.tanh(v) + 3 * current * v * (f > 2) + rng.normal(0, 2, len(t))
            conditions = {"run": f"f{f:g}_I{current:g}", "temperature_C": 20.0, "current_A": current}
            runs.append(WrittenRun(conditions, Record(t, y, force)))
    write_campaign(tmp_path / "c", iter(runs), name="c", notes="")
    tests = pc.read_campaign(tmp_path / "c")
    law = pc.add(pc.identify(tests), "condition:current_A", tests)
    before, after = law.file.history
    assert after.few_settings == (few or None)
    if few:
        assert after.refitted_nrmse > before.refitted_nrmse and after.nrmse < before.nrmse / 2
        assert "got worse" not in str(law) and "can't tell whether condition:current_A helps" in str(law)
        law.report(tmp_path / "law.html")  # a law with a further condition had no page, but a traceback
        page = (tmp_path / "law.html").read_text(encoding="utf-8")
        assert "can&#39;t tell whether condition:current_A helps" in page and '"text":"current_A"' in page


@pytest.mark.parametrize(
    "way",
    [
        history(),
        history(("power", None)),
        history(("power", None), ("+ memory", 0.03)),
        history(("power", 0.04), ("+ memory", 0.03)),
        history(("power", 0.03), ("- memory", 0.04)),
        history(("power", 0.03), ("a refit", 0.04)),
    ],
)
def test_nothing_is_said_of_what_helps_or_was_not_added(way):
    assert vain_words(way) == ""
