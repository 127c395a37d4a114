"""What speaks against a candidate stands beside it: a reader of the table sees why it isn't named."""

from types import SimpleNamespace

from pipeclamp.pages.diagnosis import promised
from pipeclamp.show.diagnosis import LEAST_HELP, NO_GAIN, against, helpful


def judged(akaike, heldout):
    return SimpleNamespace(
        effects=("memory",), akaike=akaike, heldout_nrmse=heldout, heldout_by={}, objections=(), reservations=(),
        squares=1.0, result=None,
    )  # fmt: skip


def test_what_only_steadies_is_told_so(monkeypatch):
    """It halves the error on left-out conditions, and the fit to all tests is hardly better with it."""
    monkeypatch.setattr("pipeclamp.show.diagnosis.simpler_words", lambda *_: ())
    monkeypatch.setattr("pipeclamp.show.diagnosis.left_out_at_once", lambda loops: "A, f")
    law = judged(100.0, 0.07)
    for akaike, said in ((90.0, []), (100.5, [NO_GAIN])):
        candidate = judged(akaike, 0.03)
        assert against(candidate, SimpleNamespace(law=law, loops=None, candidates=[candidate], tolerance=1.0)) == said


def test_what_takes_nothing_is_no_candidate_to_show(monkeypatch):
    """Also where it is the best one: a page had drawn it, "0% of what is missing. Against it: nothing"."""
    monkeypatch.setattr("pipeclamp.show.diagnosis.explained_share", lambda candidate, law: candidate)
    assert helpful(SimpleNamespace(law=None, candidates=[0.0])) == []
    assert helpful(SimpleNamespace(law=None, candidates=[0.4, LEAST_HELP, 0.0])) == [0.4, LEAST_HELP]


def test_what_is_named_with_a_number_is_promised_too(monkeypatch):
    """Of memory:3 or slip_spread a page had drawn the second alone."""
    monkeypatch.setattr("pipeclamp.pages.diagnosis.explained_share", lambda candidate, law: 0.7)
    candidates = [SimpleNamespace(effects=(name,), heldout_nrmse=0.02) for name in ("memory:3", "slip_spread", "gap")]
    named = ("memory:3", "slip_spread")
    found = SimpleNamespace(named=SimpleNamespace(effects=named[:1]))
    law = SimpleNamespace(heldout_nrmse=0.03)
    diagnosis = SimpleNamespace(law=law, candidates=candidates, pair=None, effects=named, found=found)
    assert [rung.label for rung in promised(diagnosis)] == ["law as it is", "+ memory:3", "or + slip_spread"]
