"""The table of narrow test plans: how they end, and what running the proposed tests makes of the ambiguous ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from table import Row, markdown_cases

ENDS = {
    "right": "named rightly",
    "ambiguous3": "ambiguous, the truth among at most three",
    "ambiguous": "ambiguous, the truth among more",
    "ambiguous_wrong": "ambiguous without the truth",
    "wrong": "another one named with confidence",
    "unknown": "unknown",
    "complete": "complete",
    "failed": "failed",
}
SETTLED = {
    "by one test": lambda row: row["settled"] == "right" and len(row["tests"]) == 1,
    "by two tests": lambda row: row["settled"] == "right" and len(row["tests"]) == 2,
    "wrongly": lambda row: row["settled"] == "wrong",
    "still ambiguous": lambda row: row["settled"] == "ambiguous",
    "complete, unknown or none proposed": lambda row: row["settled"] in ("complete", "unknown", "none proposed"),
}  # fmt: skip
BOUND = 0.9


def inside(row: Row) -> bool:
    """Tell whether a case ended ambiguous with the truth inside."""
    return row["counted"] in ("ambiguous3", "ambiguous")


def narrow_markdown(rows: Sequence[Row], command: str) -> str:
    """Give the table as Markdown."""
    lines = ["# Narrow test plans and their next tests", "", f"Made by `{command}`: {len(rows)} cases.", ""]
    forms = ("clean", "rough")
    lines += ["| the first diagnosis | clean | rough |", "|---|---|---|"]
    ends = Counter((row["counted"], row["form"]) for row in rows)
    for end, words in ENDS.items():
        lines.append(f"| {words} | " + " | ".join(str(ends[end, form] or "") for form in forms) + " |")
    for words, wanted in (("with the truth inside", inside), ("without it", _without)):
        open_rows = [row for row in rows if wanted(row)]
        lines += ["", f"| ambiguous {words}: settled | clean | rough |", "|---|---|---|"]
        for name, settled in SETTLED.items():
            lines.append(f"| {name} | " + " | ".join(_count(open_rows, settled, form) for form in forms) + " |")
    told = [row for row in rows if inside(row)]
    if told:
        right = sum(row["settled"] == "right" for row in told)
        mark = "met" if right >= BOUND * len(told) else "**missed**"
        lines += ["", f"Settled rightly: {right} of {len(told)} ({right / len(told):.0%}), bound {BOUND:.0%}: {mark}."]
    return "\n".join([*lines, *markdown_cases(rows)]) + "\n"


def _without(row: Row) -> bool:
    return bool(row["counted"] == "ambiguous_wrong")


def _count(rows: Sequence[Row], wanted: Callable[[Row], bool], form: str) -> str:
    return str(sum(wanted(row) for row in rows if row["form"] == form) or "")
