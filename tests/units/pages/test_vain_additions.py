"""That an addition doesn't help is said in one sentence: on the command line, from Python, and in the studio."""

import pytest

from pipeclamp.show.law import vain_words
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
