"""The table of other devices: how far a ladder brings the error down, and what it claims on the way."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from devices.registry import DEVICES

Row = dict[str, Any]


def ratio(row: Row) -> float:
    """Give the error on held-out conditions over the noise, where the ladder ended."""
    return float(row["after"] / row["floor"])


def median_ratio(rows: Sequence[Row]) -> float:
    """Give its median."""
    return _median_over_floor(rows, "after")


def _median_over_floor(rows: Sequence[Row], error: str) -> float:
    return float(np.median([row[error] / row["floor"] for row in rows] or [np.nan]))


def step_over_identify(rows: Sequence[Row]) -> float:
    """Give the median of a ladder step's time over that of identifying."""
    return float(np.median([rung["seconds"] / row["identify_seconds"] for row in rows for rung in row["rungs"]]))


def share(*words: str) -> Callable[[Sequence[Row]], float]:
    """Give the share of rows that came out as one of these."""
    return lambda rows: sum(row["counted"] in words for row in rows) / len(rows)


TARGETS: tuple[tuple[str, Callable[[Row], bool], Callable[[Sequence[Row]], float], float, bool], ...] = (
    ("held-out error over the floor after --auto (median)", lambda row: True, median_ratio, 2.5, False),
    ("falsely complete", lambda row: True, share("falsely complete"), 0.0, False),
    ("outside the catalogue: nothing named as the cause", lambda row: not row["truth"],
     lambda rows: 1 - share("wrong")(rows), 0.95, True),
    ("inside: nothing else named as the cause (the issue states no bound)", lambda row: bool(row["truth"]),
     lambda rows: 1 - share("wrong")(rows), 0.0, True),
    ("time of a ladder's step over that of identify (median)", lambda row: bool(row["rungs"]), step_over_identify, 10.0,
     False),
    ("failed", lambda row: True, share("failed"), 0.0, False),
)  # fmt: skip
"""Words, rows, value, bound, and whether it is a lower one (issue 13, 9)."""


def device_targets(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Give each target with what was reached; failed cases have no ratio."""
    result = []
    for words, wanted, value, bound, at_least in TARGETS:
        mine = [row for row in rows if wanted(row) and (value is not median_ratio or not row["error"])]
        reached = value(mine) if mine else float("nan")
        met = reached >= bound if at_least else reached <= bound
        result.append({"target": words, "cases": len(mine), "value": reached, "bound": bound, "at_least": at_least,
                       "met": bool(met)})  # fmt: skip
    return result


def devices_sound(rows: Sequence[Row]) -> bool:
    """Tell whether a share is as it should be: nothing failed, nothing falsely complete, no wrong cause."""
    return not any(row["counted"] in ("wrong", "falsely complete", "failed") for row in rows)


def device_markdown(rows: Sequence[Row], command: str) -> str:
    """Give the table as Markdown."""
    lines = ["# Other devices", "", f"Made by `{command}`: {len(rows)} cases.", ""]
    lines += ["| target | cases | reached | bound | |", "|---|---|---|---|---|"]
    for entry in device_targets(rows):
        if entry["cases"]:
            form = "{:.2f}" if entry["bound"] > 1 else "{:.0%}"
            sign = ">=" if entry["at_least"] else "<="
            mark = "met" if entry["met"] else "**missed**"
            values = f"{form.format(entry['value'])} | {sign} {form.format(entry['bound'])}"
            lines.append(f"| {entry['target']} | {entry['cases']} | {values} | {mark} |")
    counts = Counter(("inside" if row["truth"] else "outside", row["counted"]) for row in rows)
    ends = list(dict.fromkeys(end for _, end in sorted(counts)))
    lines += ["", "| catalogue | " + " | ".join(ends) + " |", "|---" * (len(ends) + 1) + "|"]
    for place in ("inside", "outside"):
        lines.append(f"| {place} | " + " | ".join(str(counts[place, end] or "") for end in ends) + " |")
    lines += ["", "Errors on held-out conditions, as shares of their force; the floor is their noise.", "",
              "| device | holds | before | after | floor | after/floor | counted | ladder | identify s | ladder s |",
              "|---|---|---|---|---|---|---|---|---|---|"]  # fmt: skip
    lines += [_line(row) for row in rows]
    lines += ["", "Medians over the devices of a law, over the floor.", "",
              "| law | devices | before | after | equation | source |", "|---|---|---|---|---|---|"]  # fmt: skip
    laws = [row["name"].split("/")[0] for row in rows]
    for law in dict.fromkeys(laws):
        mine = [row for row, its in zip(rows, laws, strict=True) if its == law and not row["error"]]
        before, after = (_median_over_floor(mine, key) for key in ("before", "after"))
        equation = DEVICES[law].equation.replace("|", "\\|")
        lines.append(f"| {law} | {laws.count(law)} | {before:.1f} | {after:.1f} | {equation} | {DEVICES[law].source} |")
    return "\n".join(lines) + "\n"


def _line(row: Row) -> str:
    """Give a case's line: each rung with the error of the law that was diagnosed."""
    ladder = "; ".join(_rung(rung) for rung in row["rungs"]) or row["error"][:100]
    errors = f"{row['before']:.2%} | {row['after']:.2%} | {row['floor']:.2%} | {ratio(row):.1f}"
    times = f"{row['identify_seconds']:.1f} | {row['seconds']:.0f}"
    holds = ", ".join(row["truth"]) or "outside"
    return f"| {row['name']} | {holds} | {errors} | {row['counted']} | {ladder} | {times} |"


def _rung(rung: Row) -> str:
    named = " or ".join(rung["effects"])
    words = f"{named} ({rung['kind']})" if rung["verdict"] == "missing" else f"{rung['verdict']} {named}".strip()
    return f"{rung['held_out']:.1%} {words}"
