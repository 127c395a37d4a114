"""The truth table: counts and rates per kind of case, with the targets beside them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

Row = dict[str, Any]
COLUMNS = ("right", "ambiguous3", "ambiguous", "ambiguous_wrong", "wrong", "other_part", "unknown", "complete",
           "some", "false_alarm", "failed")  # fmt: skip
WEAKEST = 0.3
"""The targets hold for what the base law can't imitate from this share of the noise on."""
KINDS = ("effect", "none", "two", "several", "unlisted")


@dataclass(frozen=True)
class Target:
    """One target of the issue: what is counted, over which rows, and the bound."""

    words: str
    form: str
    kind: str
    value: Callable[[Sequence[Row]], float]
    bound: float
    at_least: bool


def rate(*counted: str) -> Callable[[Sequence[Row]], float]:
    """Give the share of rows that came out as one of these."""
    return lambda rows: sum(row["counted"] in counted for row in rows) / len(rows)


def heldout(row: Row) -> float:
    """Give the error on held-out conditions over the noise floor where the case ended."""
    return float(row["steps"][-1]["heldout_over_floor"]) if row["steps"] else float("nan")


def median_heldout(rows: Sequence[Row]) -> float:
    """Give the median error on held-out conditions, over the floor, of cases that were settled as they should be."""
    return float(np.median([heldout(row) for row in rows if row["added"] and row["counted"] == "right"] or [np.nan]))


def worst_end(rows: Sequence[Row]) -> float:
    """Give the largest error on held-out conditions, over the floor, where cases ended."""
    return max(map(heldout, rows))


def median_end(rows: Sequence[Row]) -> float:
    """Give its median."""
    return float(np.median([heldout(row) for row in rows]))


TARGETS = (
    Target("one effect, clean: right", "clean", "effect", rate("right"), 0.98, True),
    Target("one effect, clean: right, or ambiguous with the truth among at most 3", "clean", "effect",
           rate("right", "ambiguous3"), 0.98, True),
    Target("one effect, clean: wrong with confidence", "clean", "effect", rate("wrong"), 0.01, False),
    Target("no effect, clean: complete", "clean", "none", rate("right"), 0.98, True),
    Target("not in the catalogue, clean: unknown, or a part", "clean", "unlisted", rate("right"), 0.90, True),
    Target("two effects, clean: both found", "clean", "two", rate("right"), 0.92, True),
    Target("one effect, clean: held-out error over the floor after adding (median)", "clean", "effect",
           median_heldout, 1.05, False),
    Target("two effects, clean: held-out error over the floor after adding (median)", "clean", "two",
           median_heldout, 1.05, False),
    Target("three to five effects, clean: held-out error over the floor where it ends (median)", "clean", "several",
           median_end, 1.3, False),
    Target("three to five effects, clean: the same, largest", "clean", "several", worst_end, 3.0, False),
    Target("three to five effects, clean: another cause named", "clean", "several", rate("wrong"), 0.02, False),
    Target("three to five effects, rough: held-out error over the floor where it ends (median)", "rough", "several",
           median_end, 1.3, False),
    Target("three to five effects, rough: the same, largest", "rough", "several", worst_end, 3.0, False),
    Target("three to five effects, rough: another cause named", "rough", "several", rate("wrong"), 0.02, False),
    Target("one effect, rough: right, or ambiguous with the truth among at most 3", "rough", "effect",
           rate("right", "ambiguous3"), 0.90, True),
    Target("one effect, rough: wrong with confidence", "rough", "effect", rate("wrong"), 0.03, False),
    Target("no effect, rough: complete", "rough", "none", rate("right"), 0.95, True),
    Target("one effect, rough: held-out error over the floor after adding (median)", "rough", "effect",
           median_heldout, 1.10, False),
    Target("not in the catalogue, rough: unknown, or a part (the issue states no bound)", "rough", "unlisted",
           rate("right"), 0.0, True),
    Target("two effects, rough: both found (the issue states no bound)", "rough", "two", rate("right"), 0.0, True),
)  # fmt: skip


def settled_rows(rows: Sequence[Row]) -> list[Row]:
    """Give the rows that ended ambiguous with the truth inside, for which a test was proposed and run."""
    return [row for row in rows if row.get("settled")]


def strong_enough(row: Row) -> bool:
    """Tell whether what is hidden is of a strength that the targets speak of; nothing always is."""
    return all(strength >= WEAKEST for strength in row["strengths"])


def reached(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Give each target with what was reached."""
    found = []
    for target in TARGETS:
        mine = [row for row in rows if (row["form"], row["kind"]) == (target.form, target.kind) and strong_enough(row)]
        value = target.value(mine) if mine else float("nan")
        met = bool(value >= target.bound if target.at_least else value <= target.bound)
        found.append({"target": target.words, "cases": len(mine), "value": value, "bound": target.bound,
                      "at_least": target.at_least, "met": met})  # fmt: skip
    open_rows = settled_rows(rows)
    value = sum(row["settled"] == "right" for row in open_rows) / len(open_rows) if open_rows else float("nan")
    found.append({"target": "ambiguous: settled by running the proposed test", "cases": len(open_rows),
                  "value": value, "bound": 0.9, "at_least": True, "met": bool(value >= 0.9)})  # fmt: skip
    return found


def sound(rows: Sequence[Row]) -> bool:
    """Tell whether a small share is as it should be: nothing named wrongly, nothing failed, most found.

    Of rough campaigns in which nothing is hidden one in twenty may end `unknown`, and of those of no catalogue one in
    twenty may be given a cause: one in a share is none too many.
    """
    wrong = [row for row in rows if row["counted"] == "wrong"]
    outside = [row for row in wrong if (row["kind"], row["form"]) == ("unlisted", "rough")]
    bad = len(wrong) - min(len(outside), 1) + sum(row["counted"] == "failed" for row in rows)
    alarms = [row for row in rows if row["counted"] == "false_alarm"]
    bad += sum(row["form"] == "clean" or row["steps"][0]["verdict"] != "unknown" for row in alarms)
    few = [row for row in rows if strong_enough(row) and row["kind"] != "several"]
    good = sum(row["counted"] in ("right", "ambiguous3") for row in few)
    return bad == 0 and good >= 0.8 * len(few)


def markdown(rows: Sequence[Row], command: str) -> str:
    """Give the table as Markdown."""
    lines = ["# Truth table", "", f"Made by `{command}`: {len(rows)} cases.", ""]
    lines += ["| target | cases | reached | bound | |", "|---|---|---|---|---|"]
    for entry in reached(rows):
        if not entry["cases"]:
            continue
        sign = ">=" if entry["at_least"] else "<="
        mark = "met" if entry["met"] else "**missed**"
        value = f"{entry['value']:.3f}" if entry["bound"] > 1 else f"{entry['value']:.1%}"
        bound = f"{entry['bound']:.2f}" if entry["bound"] > 1 else f"{entry['bound']:.0%}"
        lines.append(f"| {entry['target']} | {entry['cases']} | {value} | {sign} {bound} | {mark} |")
    sections: list[tuple[str, Callable[[Row], str], Callable[[Row], bool]]] = [
        ("by kind", lambda row: f"{row['kind']}, {row['form']}", lambda row: True),
        ("by strength, one effect", lambda row: f"{row['form']}, {row['strength']}",
         lambda row: row["kind"] == "effect"),
        ("by noise", lambda row: f"{row['kind']}, {row['form']}, {row['noise']}", lambda row: True),
        ("by what is hidden", lambda row: f"{row['kind']}, {row['form']}: {row['name'].split('/')[1]}",
         lambda row: row["kind"] in ("effect", "unlisted", "two", "several")),
    ]  # fmt: skip
    for title, label, wanted in sections:
        lines += ["", f"## Counts {title}", "", "| | cases | " + " | ".join(COLUMNS) + " |"]
        lines.append("|---" * (len(COLUMNS) + 2) + "|")
        chosen = [row for row in rows if wanted(row)]
        for name in dict.fromkeys(sorted((label(row) for row in chosen), key=_kind_order)):
            counts = Counter(row["counted"] for row in chosen if label(row) == name)
            cells = " | ".join(str(counts[column] or "") for column in COLUMNS)
            lines.append(f"| {name} | {sum(counts.values())} | {cells} |")
    return "\n".join([*lines, *markdown_cases(rows)]) + "\n"


def markdown_cases(rows: Sequence[Row]) -> list[str]:
    """Give the cases that were not right, a line each."""
    lines = ["", "## Cases that were not right", "", "| case | strength | counted | diagnoses | |",
              "|---|---|---|---|---|"]  # fmt: skip
    for row in rows:
        if row["counted"] != "right":
            story = "; ".join(f"{step['verdict']} {', '.join(step['effects'])}".strip() for step in row["steps"])
            strengths = ", ".join(f"{one:.2f}" for one in row["strengths"])
            ended = row["error"][:80] or (f"proposed test: {row['settled']}" if row.get("settled") else "")
            lines.append(f"| {row['name']} | {strengths} | {row['counted']} | {story} | {ended} |")
    return lines


def _kind_order(label: str) -> tuple[int, str]:
    return next((place for place, kind in enumerate(KINDS) if label.startswith(kind)), len(KINDS)), label
