"""What the ladder takes of several effects that may be the cause: told by diagnoses that are given to it."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp.pages.sections import rung_words
from pipeclamp.show.diagnosis_views import rungs_told
from pipeclamp_fmu import build
from pipeclamp_identification.diagnosis import diagnosed
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
from pipeclamp_identification.diagnosis.named import NO_PROOF, by_history
from pipeclamp_identification.workflow import auto, change, climb
from pipeclamp_models.law.step import BeforeAfter, LawStep

HELD_OUT = {"": 0.10, "oil_damper": 0.05, "memory": 0.01, "bouc_wen": 0.18, "play": 0.12}
"""Error on left-out conditions by the effect that was added last, or by all of a law's."""


def law(*effects, history=()):
    after = SimpleNamespace(base="power", effects=effects, history=history, date=None, fit=None, coefficients={})
    after.model_copy = lambda update: SimpleNamespace(**update)
    return after


def found(verdict, kind=None, *effects, together=(), other_parts=None, leaves_means_open=False):
    return SimpleNamespace(
        together=together, other_parts=other_parts or {}, leaves_means_open=leaves_means_open,
        verdict=verdict, kind=kind, effects=effects, values={}, rung=tuple, refitted=lambda *errors: (),
        cautions=tuple, words=tuple,
        proposal=None, no_test="none within the limits would do",
        naming_a_part=lambda reason: found(verdict, "part", *effects),
        naming_nothing=lambda reason: SimpleNamespace(
            verdict="unknown", kind=None, effects=(), values={}, together=(), other_parts={}, reasons=(reason,),
            leaves_means_open=leaves_means_open,
        ),
    )  # fmt: skip


def answering(answers, monkeypatch):
    """Give tests whose diagnosis is told by a law's effects, and what each effect does to the error."""

    def add(file, effect, tests, **options):
        step = SimpleNamespace(step=str(LawStep((effect,))), kind=options["kind"])
        after = law(*file.effects, effect, history=(*file.history, step))
        heldout = tuple(HELD_OUT.get(one.effects, HELD_OUT["".join(one.effects[-1:])]) for one in (file, after))
        return SimpleNamespace(
            step=LawStep((effect,)), before=file, after=after, heldout=BeforeAfter(*heldout), noise_nrmse=0.005
        )

    monkeypatch.setattr(change, "add_effect", add)
    return SimpleNamespace(
        diagnose=lambda file, **options: answers[file.effects],
        superfluous=lambda file, keep, progress: None,
        better_structures=lambda file, names, workers: [],
        simpler_structure=lambda file, names, workers: None,
        without_spare_powers=lambda file, complete, progress: None,
    )


@pytest.mark.parametrize(
    ("first", "ends"),
    [
        (("missing", "part", "oil_damper"), ("complete", [("+ oil_damper", "part"), ("+ memory", "part")])),
        (("missing", "cause", "oil_damper"), ("ambiguous", [("+ oil_damper", "cause")])),
    ],
)
def test_of_several_that_may_be_the_cause_one_is_taken_only_beside_a_part(first, ends, monkeypatch):
    answers = {
        (): found(*first),
        ("oil_damper",): found("ambiguous", "cause", "memory", "slip_spread"),
        ("oil_damper", "memory"): found("complete"),
    }
    tests = answering(answers, monkeypatch)
    settled = auto.add_until_settled(law(), tests, command="test")
    assert (settled.found.verdict, [(str(rung.change.step), rung.kind) for rung in settled.ladder]) == ends
    told = [word for rung in settled.ladder for word in rung.words]
    assert any("slip_spread would have done much the same" in word for word in told) == (ends[0] == "complete")
    assert all(NO_PROOF in rung.words for rung in settled.ladder if rung.kind == "part")


def test_of_several_that_take_a_part_the_next_is_tried_where_the_best_does_not_help(monkeypatch):
    answers = {(): found("ambiguous", "part", "bouc_wen", "memory", "slip_spread"), ("memory",): found("complete")}
    settled = auto.add_until_settled(law(), answering(answers, monkeypatch), command="test")
    assert [str(rung.change.step) for rung in settled.ladder] == ["+ memory"]
    tried, others, test, _ = settled.ladder[0].words
    assert tried.startswith("bouc_wen was tried and not added")
    assert others.startswith("it was ambiguous: slip_spread would have done much the same")
    assert test == "no test tells them apart: none within the limits would do"


@pytest.mark.parametrize(("verdict", "rivals"), [("ambiguous", ("slip_spread", "play")), ("missing", ())])
def test_a_rung_says_between_what_it_was_ambiguous_and_which_test_tells(verdict, rivals, monkeypatch):
    """At the terminal, in JSON and on the page: only that others would have done much the same had been said."""
    first = found(verdict, "part", "memory", *rivals)
    first.proposal = SimpleNamespace(words=lambda: "run a sine test at 0.6 mm")
    settled = auto.add_until_settled(
        law(), answering({(): first, ("memory",): found("complete")}, monkeypatch), command=""
    )
    (answer,) = rungs_told(settled.ladder)
    told = (" ".join(settled.words()), " ".join(rung_words(settled.ladder)))
    for text in told:
        assert ("ambiguous: slip_spread or play would have done much the same" in text) == bool(rivals)
        assert ("the test that tells them apart: run a sine test at 0.6 mm" in text.lower()) == bool(rivals)
    assert answer.rivals == rivals
    assert answer.next_test == ("the test that tells them apart: run a sine test at 0.6 mm" if rivals else None)


def test_where_none_of_several_helps_the_best_was_tried_in_vain(monkeypatch):
    answers = {(): found("ambiguous", "part", "bouc_wen", "play")}
    settled = auto.add_until_settled(law(), answering(answers, monkeypatch), command="test")
    assert not settled.ladder
    assert settled.found.verdict == "unknown"
    (reason,) = settled.found.reasons
    assert reason.startswith("bouc_wen was tried and not added")
    kept = settled.with_diagnosis("tests").diagnosis.in_vain
    assert [(one.effect, one.refitted_nrmse) for one in kept] == [("bouc_wen", (0.10, 0.18)), ("play", (0.10, 0.12))]


@pytest.mark.parametrize(("after", "added"), [(0.09999, False), (0.0998, False), (0.0994, True)])
def test_what_takes_nothing_is_not_added(after, added, monkeypatch):
    """The error had fallen from 0.09795 to 0.09792 %, by a gas spring whose parameters nothing determined."""
    monkeypatch.setitem(HELD_OUT, "play", after)
    answers = {(): found("missing", "part", "play"), ("play",): found("complete")}
    settled = auto.add_until_settled(law(), answering(answers, monkeypatch), command="test")
    assert bool(settled.ladder) is added
    if not added:
        (reason,) = settled.found.reasons
        assert reason.startswith("play went, for the law did as well without it")


@pytest.mark.parametrize(("standard_error", "added"), [(5e9, False), (None, False), (90.0, True)])
def test_what_takes_little_of_an_error_that_scatter_makes_is_added_where_it_is_determined(standard_error, added):
    """A gas spring that took two thirds beside scatter had lowered the whole error from 0.6965 to 0.6964 % only."""
    entry = SimpleNamespace(value=1757.0, standard_error=standard_error)
    step = SimpleNamespace(
        before=SimpleNamespace(coefficients={}), after=SimpleNamespace(coefficients={"F_g": entry}),
        heldout=BeforeAfter(0.006965, 0.006964), noise_nrmse=0.003,
    )  # fmt: skip
    assert change.helps([step]) is added


def test_where_what_is_named_does_not_help_another_structure_is_tried(monkeypatch):
    """As where nothing is named: the law may stand on the wrong base, or have an effect that stands for another."""
    answers = {(): found("missing", "part", "play"), ("memory:2",): found("complete")}
    tests = answering(answers, monkeypatch)
    tests.better_structures = lambda file, names, workers: [law("memory:2")]

    def exchanged(file, structure, tests, **options):
        return SimpleNamespace(
            step=LawStep(structure.effects, ("memory",)),
            after=structure,
            heldout=BeforeAfter(0.10, 0.08),
            nrmse=samples,
        )

    samples = BeforeAfter(0.09, 0.07)
    monkeypatch.setattr(climb, "exchange", exchanged)
    settled = auto.add_until_settled(law(), tests, command="test")
    assert settled.found.verdict == "complete"
    assert [(str(rung.change.step), rung.kind) for rung in settled.ladder] == [("memory -> memory:2", "revision")]
    samples = BeforeAfter(
        0.06, 0.22
    )  # a spike at each reversal, beyond the harmonics by which left-out conditions are foretold
    assert not auto.add_until_settled(law(), tests, command="test").ladder


@pytest.mark.parametrize(
    ("kind", "left", "effects"),
    [
        ("part", 0.02, ("play",)),  # what is named next leaves 0.045
        ("part", 0.048, ("oil_damper", "slip_spread", "memory")),
        ("cause", 0.02, ("oil_damper", "slip_spread", "memory")),
    ],
)
def test_where_the_next_effect_takes_little_a_part_gives_way_to_its_like(kind, left, effects, monkeypatch):
    """A clearance with slip behind it had climbed five rungs on the wrong one of two effects that act alike."""
    monkeypatch.setitem(HELD_OUT, "slip_spread", 0.045)
    answers = {
        (): found("missing", kind, "oil_damper"),
        ("oil_damper",): found("missing", "cause", "slip_spread"),
        ("oil_damper", "slip_spread"): found("missing", "cause", "memory"),
        ("oil_damper", "slip_spread", "memory"): found("complete"),
        ("play",): found("complete"),
    }
    tests = answering(answers, monkeypatch)
    tests.better_structures = lambda file, names, workers: [law("play")] if "oil_damper" in names else []
    error = BeforeAfter(0.05, left)
    exchanged = SimpleNamespace(
        step=LawStep(("play",), ("oil_damper",)), after=law("play"), heldout=error, nrmse=error, noise_nrmse=0.005
    )
    monkeypatch.setattr(climb, "exchange", lambda *of, **options: exchanged)
    assert auto.add_until_settled(law(), tests, command="test").file.effects == effects


@pytest.mark.parametrize(("base", "cycle", "told"), [("series:1:1", "a saw-tooth", True), ("series:1:1", "", False)])
def test_that_a_law_on_another_base_would_create_energy_is_told(base, cycle, told, monkeypatch):
    """An eddy-current damper's ladder had come to one, and `build-fmu` alone said so."""
    tests = answering({(): found("unknown"), ("series",): found("unknown")}, monkeypatch)
    after = law("series")
    after.base = base
    tests.better_structures = lambda file, names, workers: [after] if not file.effects else []
    step = SimpleNamespace(
        step=LawStep(base=base), after=after, heldout=BeforeAfter(0.10, 0.08), nrmse=BeforeAfter(0.09, 0.07)
    )
    monkeypatch.setattr(climb, "exchange", lambda *of, **options: step)
    monkeypatch.setattr(build, "creates_energy", lambda file: cycle)
    settled = auto.add_until_settled(law(), tests, command="test")
    assert any("this law would create energy" in word for word in settled.ladder[0].words) == told


def test_where_the_law_is_complete_a_simpler_effect_takes_the_place_of_a_part(monkeypatch):
    """Causes aren't asked: rivals of theirs were looked at when nothing else was missing."""
    answers = {
        (): found("missing", "cause", "memory"),
        ("memory",): found("missing", "part", "oil_damper"),
        ("memory", "oil_damper"): found("complete"),
        ("memory", "relaxation"): found("complete"),
    }
    monkeypatch.setitem(HELD_OUT, "oil_damper", 0.005)
    tests, asked = answering(answers, monkeypatch), []

    def simpler(file, names, workers):
        asked.append(set(names))
        return SimpleNamespace(effects=("memory", "relaxation"))

    tests.simpler_structure = simpler

    def exchanged(file, structure, tests, **options):
        step = LawStep(("relaxation",), ("oil_damper",))
        return SimpleNamespace(
            step=step, after=law(*structure.effects), heldout=BeforeAfter(0.01, 0.0101), nrmse=samples
        )

    samples = BeforeAfter(0.01, 0.0101)
    monkeypatch.setattr(climb, "exchange", exchanged)
    settled = auto.add_until_settled(law(), tests, command="test")
    assert settled.file.effects == ("memory", "relaxation")
    assert [rung.kind for rung in settled.ladder] == ["cause", "part", "revision"]
    assert "fewer parameters" in settled.ladder[-1].words[0]
    assert asked == [{"oil_damper"}]
    samples = BeforeAfter(0.01, 0.02)
    assert auto.add_until_settled(law(), tests, command="test").file.effects == ("memory", "oil_damper")


@pytest.mark.parametrize(
    ("verdict", "after", "ends"),
    [
        ("complete", 0.0101, ["cause", "revision"]),
        ("complete", 0.0108, ["cause"]),
        ("unknown", 0.0108, ["cause", "revision"]),
        ("unknown", 0.02, ["cause"]),
    ],
)
def test_at_the_end_powers_of_the_amplitude_go_that_the_memory_spares(verdict, after, ends, monkeypatch):
    """A law that lacks something may err a little more; the powers may imitate what it lacks."""
    tests = answering({(): found("missing", "cause", "memory"), ("memory",): found(verdict)}, monkeypatch)
    asked = []

    def spared(file, complete, progress):
        asked.append((file.effects, complete))
        return SimpleNamespace(effects=file.effects) if len(asked) == 1 else None

    tests.without_spare_powers = spared
    step = LawStep(held=("k1_A", "k3_A"))

    def held(file, structure, tests, **options):
        return SimpleNamespace(
            step=step, after=law(*structure.effects), heldout=BeforeAfter(0.01, after), nrmse=BeforeAfter(0.01, 0.01)
        )

    monkeypatch.setattr(change, "exchange", held)
    settled = auto.add_until_settled(law(), tests, command="test")
    assert [rung.kind for rung in settled.ladder] == ends
    assert settled.found.verdict == verdict
    assert asked == [(("memory",), verdict == "complete")] * len(ends)
    if ends[-1] == "revision":
        assert settled.ladder[-1].words[0].startswith("without k1_A and k3_A the law errs by next to no more")


@pytest.mark.parametrize(
    ("steps", "kind"),
    [
        ([("+ oil_damper", "part")], "part"),
        ([("+ bouc_wen", "part"), ("bouc_wen -> oil_damper", "part")], "part"),
        ([("+ oil_damper", "cause")], "cause"),
        ([("base series", None), ("+ oil_damper", "cause")], "part"),
        ([("+ oil_damper", "cause"), ("without k3_A", None)], "part"),
        ([("+ oil_damper", "cause"), ("without k3_A", None), ("with k3_A", None)], "cause"),
        ([("+ bouc_wen", "part"), ("- bouc_wen", None), ("+ oil_damper", None)], "cause"),
    ],
)
def test_beside_a_part_nothing_is_called_the_cause(steps, kind):
    """The part may stand for something else, and what explains the rest beside it for another rest."""
    history = [SimpleNamespace(step=step, kind=meant) for step, meant in steps]
    file = SimpleNamespace(base="series", effects=("oil_damper",), history=history, diagnosis=None, fit=None)
    assert by_history(found("missing", "cause", "memory"), file, "of the tests").kind == kind


def test_an_effect_that_went_does_not_come_back_in_the_place_of_another(monkeypatch):
    answers = {
        (): found("missing", "part", "oil_damper"),
        ("oil_damper",): found("missing", "part", "memory"),
        ("memory",): found("ambiguous", "part", "bouc_wen", "oil_damper"),
    }
    tests = answering(answers, monkeypatch)
    tests.superfluous = lambda file, keep, progress: "oil_damper" if len(file.effects) == 2 else None

    def remove(file, effect, tests, **options):
        after = law(*(name for name in file.effects if name != effect))
        return SimpleNamespace(
            step=LawStep(gone=(effect,)), after=after, heldout=BeforeAfter(0.01, 0.01), nrmse=BeforeAfter(0.01, 0.01)
        )

    monkeypatch.setattr(change, "remove_effect", remove)
    added, add = [], change.add_effect

    def noted(file, effect, tests, **options):
        added.append(effect)
        return add(file, effect, tests, **options)

    monkeypatch.setattr(change, "add_effect", noted)
    settled = auto.add_until_settled(law(), tests, command="test")
    assert settled.file.effects == ("memory",)
    assert added == ["oil_damper", "memory", "bouc_wen"]
    went, tried = settled.in_vain
    assert (went.effect, tried.effect) == ("oil_damper", "bouc_wen")


@pytest.mark.parametrize("most", [3, 12])
def test_an_effect_that_went_is_not_named_at_the_end(most, monkeypatch):
    """Nor is the next diagnosis to name it: also where the ladder ends for its length."""
    answers = {
        (): found("missing", "part", "oil_damper"),
        ("oil_damper",): found("missing", "part", "memory"),
        ("memory",): found("missing", "part", "oil_damper"),
    }
    tests = answering(answers, monkeypatch)
    tests.superfluous = lambda file, keep, progress: "oil_damper" if len(file.effects) == 2 else None

    def remove(file, effect, tests, **options):
        return SimpleNamespace(
            step=LawStep(gone=(effect,)),
            after=law("memory"),
            heldout=BeforeAfter(0.0100, 0.0101),
            nrmse=BeforeAfter(0.01, 0.01),
        )

    monkeypatch.setattr(change, "remove_effect", remove)
    settled = auto.add_until_settled(law(), tests, command="test", most=most)
    assert settled.found.verdict == "unknown"
    assert [one.effect for one in settled.with_diagnosis("tests").diagnosis.in_vain] == ["oil_damper"]
    (reason,) = settled.found.reasons
    assert reason.startswith("oil_damper went, for the law did as well without it (1.00% -> 1.01%)")


def test_where_the_first_way_ends_without_a_name_another_is_climbed(monkeypatch):
    """The part that took most led astray; the one that took nearly as much is on the way to the truth."""
    astray = found("missing", "part", "oil_damper", other_parts={"play": 0.4, "slip_spread": 0.9})
    answers = {
        (): astray,
        ("oil_damper",): found("unknown"),
        ("slip_spread",): found("missing", "part", "memory"),
        ("slip_spread", "memory"): found("complete"),
    }
    monkeypatch.setitem(HELD_OUT, "slip_spread", 0.06)
    tests, seen = answering(answers, monkeypatch), []
    settled = auto.add_until_settled(law(), tests, command="test", seen=lambda found, file: seen.append(file.effects))
    assert [(str(rung.change.step), rung.kind) for rung in settled.ladder] == [
        ("+ slip_spread", "part"),
        ("+ memory", "part"),
    ]
    assert settled.ladder[0].words[0].startswith("by itself it takes 90% of what oil_damper does")
    assert "5.00%" in settled.ladder[0].words[0]
    assert seen == [(), ("oil_damper",), ("slip_spread",), ("slip_spread", "memory"), ("slip_spread", "memory")]


def test_another_way_that_ends_no_better_is_not_taken(monkeypatch):
    answers = {
        (): found("missing", "part", "oil_damper", other_parts={"play": 0.9}),
        ("oil_damper",): found("unknown"),
        ("play",): found("unknown"),
    }
    settled = auto.add_until_settled(law(), answering(answers, monkeypatch), command="test")
    assert [str(rung.change.step) for rung in settled.ladder] == ["+ oil_damper"]


def test_of_ways_that_end_as_well_the_one_with_fewer_effects_is_taken(monkeypatch):
    """Along other motions than sines each effect of the longer one may add what no test has asked."""
    answers = {
        (): found("missing", "part", "oil_damper", other_parts={"slip_spread": 0.9}),
        ("oil_damper",): found("missing", "part", "memory"),
        ("oil_damper", "memory"): found("unknown"),
        ("slip_spread",): found("unknown"),
    }
    monkeypatch.setitem(HELD_OUT, "slip_spread", 0.0102)
    settled = auto.add_until_settled(law(), answering(answers, monkeypatch), command="test")
    assert settled.file.effects == ("slip_spread",)


def test_a_way_whose_law_leaves_mean_forces_open_errs_less_only_without_them(monkeypatch):
    """It had taken the place of five effects that were all there, at half of what scatter makes."""
    answers = {
        (): found("missing", "part", "oil_damper", other_parts={"slip_spread": 0.9}),
        ("oil_damper",): found("unknown"),
        ("slip_spread",): found("unknown", leaves_means_open=True),
    }
    monkeypatch.setitem(HELD_OUT, "slip_spread", 0.01)
    settled = auto.add_until_settled(law(), answering(answers, monkeypatch), command="test")
    assert settled.file.effects == ("oil_damper",)


def test_two_that_help_only_together_that_do_not_were_tried_in_vain(monkeypatch):
    answers = {(): found("missing", "part", "play", together=("play", "bouc_wen"))}
    settled = auto.add_until_settled(law(), answering(answers, monkeypatch), command="test")
    assert not settled.ladder
    assert [(one.effect, one.refitted_nrmse) for one in settled.in_vain] == [("play with bouc_wen", (0.10, 0.18))]


def test_a_way_that_comes_to_a_law_of_the_first_one_goes_no_further(monkeypatch):
    answers = {
        (): found("missing", "part", "oil_damper", other_parts={"memory": 0.9}),
        ("oil_damper",): found("missing", "part", "memory"),
        ("oil_damper", "memory"): found("unknown"),
        ("memory",): found("missing", "part", "oil_damper"),
    }
    monkeypatch.setitem(HELD_OUT, "memory", 0.04)
    monkeypatch.setitem(HELD_OUT, ("memory",), 0.06)
    tests, seen = answering(answers, monkeypatch), []
    diagnose = tests.diagnose
    tests.diagnose = lambda file, **options: (seen.append(file.effects), diagnose(file, **options))[1]
    settled = auto.add_until_settled(law(), tests, command="test")
    assert settled.file.effects == ("oil_damper", "memory")
    assert seen == [(), ("oil_damper",), ("oil_damper", "memory"), ("memory",)]


def test_nothing_is_exchanged_for_a_law_that_another_way_came_by(monkeypatch):
    """The second way up a measured friction device had ended so, though what was named there took two fifths."""
    answers = {
        (): found("missing", "part", "oil_damper", other_parts={"slip_spread": 0.9}),
        ("oil_damper",): found("unknown"),
        ("slip_spread",): found("missing", "part", "memory"),
        ("slip_spread", "memory"): found("complete"),
    }
    for effect, error in (("oil_damper", 0.07), ("slip_spread", 0.06), ("memory", 0.05)):
        monkeypatch.setitem(HELD_OUT, effect, error)
    tests = answering(answers, monkeypatch)
    tests.better_structures = lambda file, names, workers: [law("oil_damper")] if "slip_spread" in file.effects else []
    error = BeforeAfter(0.06, 0.03)
    exchanged = SimpleNamespace(
        step=LawStep(("oil_damper",), ("slip_spread",)), after=law("oil_damper"), heldout=error, nrmse=error
    )
    monkeypatch.setattr(climb, "exchange", lambda *of, **options: exchanged)
    assert auto.add_until_settled(law(), tests, command="test").file.effects == ("slip_spread", "memory")


def test_another_way_begins_with_an_effect_that_the_end_lacks(monkeypatch):
    """With one that the end has all the same, it takes much the same in another order; and one is tried."""
    answers = {
        (): found("missing", "part", "oil_damper", other_parts={"memory": 1.2, "slip_spread": 0.6, "play": 0.55}),
        ("oil_damper",): found("missing", "part", "memory", other_parts={"slip_spread": 0.7}),
        ("oil_damper", "memory"): found("unknown"),
        ("oil_damper", "slip_spread"): found("unknown"),
    }
    monkeypatch.setitem(HELD_OUT, "slip_spread", 0.06)
    tests, seen = answering(answers, monkeypatch), []
    auto.add_until_settled(law(), tests, command="test", seen=lambda found, file: seen.append(file.effects))
    first, last = [(), ("oil_damper",), ("oil_damper", "memory")], ("oil_damper", "memory")
    assert seen == [*first, ("oil_damper", "slip_spread"), last]


def test_no_other_way_is_climbed_by_what_something_speaks_against():
    """At a measured friction device `bouc_wen` with two shapes at their bounds had been gone by, and `memory:2` not."""

    def judged(effect, left, may_be_cause):
        score = SimpleNamespace(mean_squares=np.full(4, left), axes=None)
        return SimpleNamespace(effects=(effect,), score=score, missing=4.0, may_be_cause=may_be_cause)

    others = (judged("bouc_wen", 0.6, False), judged("memory:2", 0.7, True))
    diagnosis = SimpleNamespace(law=judged("", 1.0, True), explained=0.5, found=SimpleNamespace(others=others))
    parts = RecordDiagnosed.other_parts.fget(SimpleNamespace(diagnosis=diagnosis))
    assert parts == {"memory:2": pytest.approx(0.6)}


@pytest.mark.parametrize(("after", "fits"), [(0.02, True), (0.0499, False)])
def test_a_ladder_ends_with_the_values_that_the_verdict_is_on(after, fits, monkeypatch):
    """A fit that begins at another law's values had found a lower valley than the law's, which nobody got."""
    last = found("complete")
    last.values = {"k10": 2.0}
    answers = {(): found("missing", "cause", "oil_damper"), ("oil_damper",): last}
    starts = []

    def refit(file, tests, *, start, **options):
        starts.append(start)
        again = law(*file.effects, history=file.history)
        answers[again.effects] = found("complete")
        return SimpleNamespace(
            step=LawStep(), after=again, heldout=BeforeAfter(0.05, after), nrmse=BeforeAfter(0.04, 0.02),
        )  # fmt: skip

    monkeypatch.setattr(climb, "refit", refit)
    settled = auto.add_until_settled(law(), answering(answers, monkeypatch), command="test")
    assert starts == [{"k10": 2.0}]
    steps = [(str(rung.change.step), rung.kind) for rung in settled.ladder]
    assert steps == [("+ oil_damper", "cause"), *([("a refit", "revision")] if fits else [])]


@pytest.mark.parametrize(("own", "told"), [(0.0074, True), (0.00385, False)])
def test_values_that_err_less_than_the_laws_own_are_given_and_told(own, told, monkeypatch):
    monkeypatch.setattr(diagnosed, "misfits", lambda law, campaign, loops: law.error)
    monkeypatch.setattr(diagnosed, "overall_nrmse", lambda runs: runs)
    judged = SimpleNamespace(result=SimpleNamespace(law=SimpleNamespace(values={"k10": 2.0}, error=0.0038)))
    diagnosis = SimpleNamespace(
        verdict="complete", found=SimpleNamespace(named=None), law=judged, loops=None,
    )  # fmt: skip
    campaign = SimpleNamespace(of_sines=lambda: None)
    one = RecordDiagnosed(diagnosis, SimpleNamespace(campaign=campaign, runs=own))
    assert one.values == ({"k10": 2.0} if told else {})
    assert ["0.38% of the force, not 0.74%" in words for words in one.other_values()] == [True] * told
