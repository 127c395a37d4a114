"""The truth table counts what a diagnosis said in the words that the issue's targets use."""

import json
import subprocess
import sys

import pytest
from project import TRUTH_TABLE


def step(verdict, *effects, kind="cause"):
    from judge import Step

    return Step(verdict, kind if effects else None, effects, 1.0, 0.0, (), (), ())


def case(kind, *hidden):
    from cases import Case

    return Case(kind, hidden, "clean", "middle", "low", "A")


@pytest.mark.parametrize(
    ("kind", "hidden", "verdict", "effects", "added", "expected"),
    [
        ("effect", ("gap",), "missing", ("gap",), ["gap"], "right"),
        ("effect", ("memory",), "missing", ("memory",), ["memory:3"], "right"),
        ("effect", ("condition",), "missing", ("condition:bolt_torque_Nm",), [], "right"),
        ("effect", ("gap",), "missing", ("memory",), ["memory"], "wrong"),
        ("effect", ("gap",), "ambiguous", ("memory", "gap"), [], "ambiguous3"),
        ("effect", ("gap",), "ambiguous", ("memory", "viscous", "delay", "gap"), [], "ambiguous"),
        ("effect", ("gap",), "ambiguous", ("memory", "viscous"), [], "ambiguous_wrong"),
        ("effect", ("gap",), "unknown", (), [], "unknown"),
        ("effect", ("gap",), "complete", (), [], "complete"),
        ("none", (), "complete", (), [], "right"),
        ("none", (), "unknown", (), [], "false_alarm"),
        ("unlisted", ("mains_hum",), "unknown", (), [], "right"),
        ("unlisted", ("mains_hum",), "missing", ("gap",), ["gap"], "wrong"),
        ("unlisted", ("mains_hum",), "complete", (), [], "complete"),
        ("two", ("gap", "viscous"), "complete", (), ["viscous", "gap"], "right"),
        ("two", ("gap", "viscous"), "complete", (), ["viscous"], "some"),
        ("two", ("gap", "viscous"), "complete", (), ["viscous", "delay"], "other_part"),
        ("two", ("gap", "viscous"), "ambiguous", ("gap", "memory"), ["viscous"], "ambiguous3"),
    ],
)
def test_how_a_case_came_out(kind, hidden, verdict, effects, added, expected):
    from judge import counted

    assert counted(case(kind, *hidden), [step(verdict, *effects)], added) == expected


@pytest.mark.parametrize(
    ("kind", "hidden", "named", "added", "expected"),
    [
        ("effect", ("gap",), "gap", ["gap"], "right"),
        ("effect", ("gap",), "memory", ["memory"], "other_part"),
        ("unlisted", ("mains_hum",), "gap", ["gap"], "right"),
        ("two", ("gap", "viscous"), "delay", ["viscous", "delay"], "other_part"),
        ("several", ("gap", "viscous", "memory"), "delay", ["viscous", "delay"], "other_part"),
        ("several", ("gap", "viscous", "memory"), "gap", ["viscous", "gap"], "some"),
    ],
)
def test_a_part_claims_less_than_a_cause(kind, hidden, named, added, expected):
    from judge import counted

    assert counted(case(kind, *hidden), [step("missing", named, kind="part")], added) == expected


def row(counted, strength=1.0):
    return {
        "name": f"effect/gap/clean/middle/low/A/{counted}", "kind": "effect", "form": "clean", "noise": "low",
        "strength": "middle", "strengths": [strength], "counted": counted, "added": ["gap"], "settled": "", "error": "",
        "steps": [{"verdict": "missing", "effects": ["gap"], "heldout_over_floor": 1.01}],
    }  # fmt: skip


def test_targets_leave_weak_cases_aside_and_say_what_was_missed():
    from table import markdown, reached, sound

    rows = [row("right"), row("right"), row("wrong"), row("unknown", strength=0.2)]
    targets = {entry["target"]: entry for entry in reached(rows)}
    right = targets["one effect, clean: right"]
    assert right["cases"] == 3
    assert right["value"] == pytest.approx(2 / 3)
    assert not right["met"]
    assert not sound(rows)
    assert sound(rows[:2])
    outside = row("wrong") | {"kind": "unlisted", "form": "rough"}
    assert sound([*9 * [row("right")], outside])
    assert not sound([*9 * [row("right")], outside, outside])
    text = markdown(rows, "the command")
    assert "| one effect, clean: right | 3 | 66.7% | >= 98% | **missed** |" in text
    assert "effect/gap/clean/middle/low/A/wrong" in text


def test_several_draws_are_counted_together_from_their_journals(tmp_path):
    """Of a run that was killed a journal may hold half a line at its end."""
    for name, rows in (("cases-1.jsonl", [row("right")]), ("cases-2.jsonl", [row("right"), row("wrong")])):
        text = "".join(f"{json.dumps(one)}\n" for one in rows) + json.dumps(row("failed"))[:40]
        (tmp_path / name).write_text(text, encoding="utf-8")
    program = [
        sys.executable,
        TRUTH_TABLE / "run.py",
        "--journals",
        tmp_path / "cases-1.jsonl",
        tmp_path / "cases-2.jsonl",
    ]
    told = subprocess.run(program, capture_output=True, encoding="utf-8", check=True).stdout
    assert "run.py --journals cases-1.jsonl cases-2.jsonl`: 3 cases." in told
    assert "| one effect, clean: right | 3 | 66.7% |" in told
