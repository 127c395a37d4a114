"""The table of discovery: what was asked of it, what it reached, and every case."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from hidden import EFFECTS, effect_id
from table import Row, strong_enough

from beyond.form import RIGHT_FORM
from beyond.judge import NEAR_FLOOR
from beyond.registry import LAWS

BEYOND_COUNTS = ("right form", "wrong form", "wrong kind", "nothing left", "nothing proposed", "failed")
CRITERIA = f"""Errors are on held-out conditions, over that of the truth itself (the floor). *Before*: the law as
identified; *auto*: after `diagnose --auto`; *after*: with what `discover --auto` added. Targets of errors count all
cases in which the base law can't imitate at least 0.3 of the force noise.

*Left over*: such a case in which the law after `--auto` errs by more than {NEAR_FLOOR["clean"]:g} (clean) or
{NEAR_FLOOR["rough"]:g} (rough) times the floor, so that there is something to propose. *Right form*: what is proposed
is of a family that the law's row in the list below states, and its force differs from the hidden one by at most
{RIGHT_FORM:.0%} (rms), over the harmonics of the held-out motions, both freed of what the parameters of the law beside
it can do: of effects in whose place it stands none are left. *Nothing is missing*: nothing was hidden, or an effect of
the catalogue that the ladder found; an effect that joins there counts as proposed. *Displaced*: an effect of the
catalogue was hidden, and a term is proposed in its place, of the base law or after a ladder that didn't find it."""


def near_floor(rows: Sequence[Row]) -> float:
    """Give the share of cases that end near the floor."""
    return float(np.mean([row["discovered"] <= NEAR_FLOOR[row["form"]] for row in rows]))


def share(*words: str) -> Callable[[Sequence[Row]], float]:
    """Give the share of rows that came out as one of these."""
    return lambda rows: sum(row["counted"] in words for row in rows) / len(rows)


def is_beyond(row: Row) -> bool:
    """Tell whether a law was hidden that no catalogue has, strong enough to be seen."""
    return row["kind"] == "beyond" and strong_enough(row)


def is_left_over(row: Row) -> bool:
    """Tell whether the ladder left something of it."""
    return is_beyond(row) and not row["diagnosed"] <= NEAR_FLOOR[row["form"]]


def is_beside(row: Row) -> bool:
    """Tell whether such a law was hidden beside an effect of the catalogue, both strong enough to be seen."""
    return row["kind"] == "beside" and strong_enough(row)


def is_left_beside(row: Row) -> bool:
    """Tell whether the ladder left something of it."""
    return is_beside(row) and not row["diagnosed"] <= NEAR_FLOOR[row["form"]]


def has_nothing_missing(row: Row) -> bool:
    """Tell whether the law, where it was asked, lacked nothing that was hidden."""
    if row["kind"] == "none":
        return True
    hidden = effect_id(row["law"]) if row["law"] in EFFECTS else None
    return row["kind"] == "effect" and hidden in {name.partition(":")[0] for name in row["ladder"]} | set(row["ladder"])


TARGETS: tuple[tuple[str, Callable[[Row], bool], Callable[[Sequence[Row]], float], dict[str, float], bool], ...] = (
    ("held-out error near the floor", is_beyond, near_floor, {"clean": 0.8, "rough": 0.6}, True),
    ("left over by the ladder: right form", is_left_over, share("right form"), {"clean": 0.5, "rough": 0.3}, True),
    ("left over by the ladder: wrong form or kind (the issue states no bound)", is_left_over,
     share("wrong form", "wrong kind"), {"clean": 1.0, "rough": 1.0}, False),
    ("beside an effect of the catalogue: held-out error near the floor", is_beside, near_floor,
     {"clean": 0.8, "rough": 0.6}, True),
    ("beside an effect, left over by the ladder: right form", is_left_beside, share("right form"),
     {"clean": 0.5, "rough": 0.3}, True),
    ("nothing is missing: something proposed", has_nothing_missing, share("false alarm", "displaced"),
     {"clean": 0.01, "rough": 0.02}, False),
    ("an effect of the catalogue displaced", lambda row: row["kind"] == "effect", share("displaced"),
     {"clean": 0.01, "rough": 0.01}, False),
    ("failed", lambda row: True, share("failed"), {"clean": 0.0, "rough": 0.0}, False),
)  # fmt: skip
"""Words, rows, value, bounds, and whether they are lower ones (issue 16, 5)."""


def beyond_targets(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Give each target with what was reached."""
    found = []
    for words, wanted, value, bounds, at_least in TARGETS:
        for form, bound in bounds.items():
            mine = [row for row in rows if row["form"] == form and wanted(row)]
            reached = value(mine) if mine else float("nan")
            met = reached >= bound if at_least else reached <= bound
            found.append({"target": f"{form}: {words}", "cases": len(mine), "value": reached, "bound": bound,
                          "at_least": at_least, "met": bool(met)})  # fmt: skip
    return found


def beyond_sound(rows: Sequence[Row]) -> bool:
    """Tell whether a share is as it should be: nothing failed, nothing proposed where nothing is missing."""
    return not any(row["counted"] in ("false alarm", "displaced", "failed") for row in rows)


def beyond_markdown(rows: Sequence[Row], command: str) -> str:
    """Give the table as Markdown."""
    lines = ["# Beyond the catalogue", "", f"Made by `{command}`: {len(rows)} cases.", "", CRITERIA, ""]
    lines += ["| target | cases | reached | bound | |", "|---|---|---|---|---|"]
    for entry in beyond_targets(rows):
        if entry["cases"]:
            sign = ">=" if entry["at_least"] else "<="
            mark = "met" if entry["met"] else "**missed**"
            values = f"{entry['value']:.0%} | {sign} {entry['bound']:.0%}"
            lines.append(f"| {entry['target']} | {entry['cases']} | {values} | {mark} |")
    lines += ["", "| law | cases | " + " | ".join(BEYOND_COUNTS) + " |", "|---" * (len(BEYOND_COUNTS) + 2) + "|"]
    laws = [row for row in rows if row["kind"] in ("beyond", "beside")]
    for law in dict.fromkeys(row["law"] for row in laws):
        counts = Counter(row["counted"] for row in laws if row["law"] == law)
        lines.append(
            f"| {law} | {counts.total()} | " + " | ".join(str(counts[one] or "") for one in BEYOND_COUNTS) + " |"
        )
    lines += ["", "| case | strength | before | auto | after | ladder | counted | differs | proposed, or why not | s |",
              "|---|---|---|---|---|---|---|---|---|---|"]  # fmt: skip
    lines += [_line(row) for row in rows]
    lines += ["", "| law | may be proposed as | equation | source |", "|---|---|---|---|"]
    for name, law in LAWS.items():
        equation = law.equation.replace("|", "\\|")
        lines.append(f"| {name} | {' or '.join(sorted(law.families))} | {equation} | {law.source} |")
    return "\n".join(lines) + "\n"


def _line(row: Row) -> str:
    found = row["found"] or {"proposed": False, "formula": "", "reason": row["error"][:120], "family": ""}
    words = f"{found['family']}: {found['formula']}" if found["proposed"] else found["reason"]
    if instead := found.get("instead"):  # draws before effects could join don't say
        words = f"{instead} of the catalogue joins; {words}"
    if row["first"] and row["first"]["proposed"]:
        words = f"of the base law: {row['first']['formula']}; then {words}"
    errors = " | ".join(_number(row[key]) for key in ("identified", "diagnosed", "discovered"))
    strengths = ", ".join(f"{one:.2f}" for one in row["strengths"])
    told = words.replace("|", "\\|")
    return (
        f"| {row['name']} | {strengths} | {errors} | {', '.join(row['ladder'])} | {row['counted']} | "
        f"{_number(row['difference'])} | {told} | {row['seconds']:.0f} |"
    )


def _number(value: float | None) -> str:
    return "" if value is None or math.isnan(value) else f"{value:.2f}"
