"""The table of dW and W alone: how often a diagnosis is right, per test plan."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from metric_loops import PLANS
from narrow_table import ENDS
from table import KINDS, Row, markdown_cases, rate

SEEN_FROM = 1.0
"""What is hidden is counted as to be found from this multiple of the scatter on: what the base law can't imitate of
log dW and log W over what scatters of them, rms each."""
WORDS = {
    "effect": "One effect",
    "none": "Nothing, or what dW and W can't show",
    "two": "Two effects",
    "unlisted": "In no catalogue",
}
MEANING = {
    "effect": {},
    "none": {"right": "`complete`", "false_alarm": "something is said to be missing"},
    "two": {"right": "both found, nothing else", "one": "one found, nothing else", "wrong": "another one added"},
    "unlisted": {"right": "`unknown`", "wrong": "an effect named with confidence",
                 "ambiguous_wrong": "some effects named as possible"},
}  # fmt: skip
"""What an end means where it isn't as for one effect."""
BOUNDS = (
    ("one effect: another one named with confidence", "effect", rate("wrong"), 0.03),
    ("nothing to be seen: something is said to be missing", "none", rate("false_alarm"), 0.05),
)
"""Most that may go wrong, over all cases, however weak."""


def seen(row: Row) -> bool:
    """Tell whether what is hidden is large enough to be found; nothing always is."""
    return all(strength >= SEEN_FROM for strength in row["strengths"])


def metric_bounds(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Give each bound with what was reached."""
    found = []
    for words, kind, value, bound in BOUNDS:
        mine = [row for row in rows if row["kind"] == kind]
        reached = value(mine) if mine else float("nan")
        found.append({"target": words, "cases": len(mine), "value": reached, "bound": bound, "at_least": False,
                      "met": not reached > bound})  # fmt: skip
    return found


def metrics_sound(rows: Sequence[Row]) -> bool:
    """Tell whether a share is as it should be: bounds held, nothing failed."""
    return all(entry["met"] for entry in metric_bounds(rows)) and not any(row["counted"] == "failed" for row in rows)


def metric_markdown(rows: Sequence[Row], command: str) -> str:
    """Give the table as Markdown."""
    lines = ["# Diagnosis on dW and W alone", "", f"Made by `{command}`: {len(rows)} cases."]
    for entry in metric_bounds(rows):
        mark = "met" if entry["met"] else "**missed**"
        share = f"{entry['value']:.1%} of {entry['cases']}, at most {entry['bound']:.0%}"
        lines += ["", f"{entry['target'].capitalize()}: {share}: {mark}."]
    for kind in KINDS:
        mine = [row for row in rows if row["kind"] == kind]
        if mine:
            lines += ["", *_part(f"{WORDS[kind]}, from {SEEN_FROM:g} times the scatter on", kind, mine, seen)]
        if any(not seen(row) for row in mine):
            lines += ["", *_part(f"{WORDS[kind]}, weaker", kind, mine, lambda row: not seen(row))]
    by_strength: dict[str, list[Row]] = {}
    for row in rows:
        if row["kind"] == "effect" and seen(row):
            by_strength.setdefault(f"{row['strength']}, {row['form']}", []).append(row)
    lines += ["", "| one effect | cases | right | right, or the truth among those left open |", "|---|---|---|---|"]
    for label, mine in sorted(by_strength.items()):
        right, told = rate("right")(mine), rate("right", "ambiguous3", "ambiguous")(mine)
        lines.append(f"| {label} | {len(mine)} | {right:.0%} | {told:.0%} |")
    return "\n".join([*lines, *markdown_cases(rows)]) + "\n"


def _part(title: str, kind: str, rows: Sequence[Row], wanted: Callable[[Row], bool]) -> list[str]:
    """Give how the cases of one kind ended in each plan, clean and rough ones together."""
    chosen = [row for row in rows if wanted(row)]
    plans = [plan for plan in PLANS if any(row["design"] == plan for row in chosen)]
    lines = [f"| {title} | " + " | ".join(plans) + " |", "|---" * (len(plans) + 1) + "|"]
    ends = {**ENDS, "one": "one found", "false_alarm": "false alarm", **MEANING[kind]}
    for end, words in ends.items():
        counts = [sum(row["counted"] == end for row in chosen if row["design"] == plan) for plan in plans]
        if any(counts):
            lines.append(f"| {words} | " + " | ".join(str(count or "") for count in counts) + " |")
    totals = [sum(row["design"] == plan for row in chosen) for plan in plans]
    return [*lines, "| cases | " + " | ".join(map(str, totals)) + " |"]
