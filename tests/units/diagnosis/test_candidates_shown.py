"""The table of candidates that a diagnosis prints."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pipeclamp.show import diagnosis as shown


@pytest.mark.parametrize(
    ("taken", "begins"), [(0.3, "the law with each effect, best first"), (0.001, "no effect of the catalogue helps")]
)
def test_a_table_of_what_helps_says_where_nothing_does(taken, begins, monkeypatch):
    """It had said "the law with each effect, best first" above a single row, the law's own."""
    monkeypatch.setattr(shown, "explained_share", lambda candidate, law: taken)
    monkeypatch.setattr(shown, "left_out_at_once", lambda loops: "A, f")
    monkeypatch.setattr(shown, "against", lambda candidate, diagnosis: [])
    law = SimpleNamespace(heldout_nrmse=0.06, heldout_by={})
    memory = SimpleNamespace(effects=("memory",), heldout_nrmse=0.05, heldout_by={}, squares=1.0)
    table = shown.candidate_table(SimpleNamespace(law=law, candidates=[memory], pair=None, loops=None))
    assert table.caption.startswith(begins)
    assert ("no help: memory" in table.caption) == (taken < 0.005)
