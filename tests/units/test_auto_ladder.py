"""What the ladder takes of several effects that may be the cause: told by diagnoses that are given to it."""

from types import SimpleNamespace

import pytest

from pipeclamp_identification.workflow import auto

HELD_OUT = {"": 0.10, "oil_damper": 0.05, "memory": 0.01}


def law(*effects):
    return SimpleNamespace(effects=effects, date=None)


def found(verdict, kind=None, *effects):
    return SimpleNamespace(
        verdict=verdict, kind=kind, effects=effects, values={}, rung=tuple, cautions=tuple, words=tuple
    )


@pytest.mark.parametrize(
    ("first", "ends"),
    [
        (("missing", "part", "oil_damper"), ("complete", [("oil_damper", "part"), ("memory", "part")])),
        (("missing", "cause", "oil_damper"), ("ambiguous", [("oil_damper", "cause")])),
    ],
)
def test_of_several_that_may_be_the_cause_one_is_taken_only_beside_a_part(first, ends, monkeypatch):
    answers = {
        (): found(*first),
        ("oil_damper",): found("ambiguous", "cause", "memory", "slip_spread"),
        ("oil_damper", "memory"): found("complete"),
    }
    tests = SimpleNamespace(
        diagnose=lambda file, **options: answers[file.effects], superfluous=lambda file, keep, progress: None
    )

    def add(file, effect, tests, **options):
        after = law(*file.effects, effect)
        heldout = (HELD_OUT["".join(file.effects[-1:])], HELD_OUT[effect])
        return SimpleNamespace(effect=effect, after=after, heldout=heldout)

    monkeypatch.setattr(auto, "add_effect", add)
    settled = auto.add_until_settled(law(), tests, command="test")
    assert (settled.found.verdict, [(rung.change.effect, rung.kind) for rung in settled.ladder]) == ends
    told = [word for rung in settled.ladder for word in rung.words]
    assert any("slip_spread would have done much the same" in word for word in told) == (ends[0] == "complete")
