"""Suspects change nothing at their neutral values; what can't be told apart is said to be ambiguous."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cantilever import shaken

from pipeclamp.pages.page import render
from pipeclamp.pages.system.on_pipe import attributed_sections
from pipeclamp.show.on_pipe import attribution_words
from pipeclamp_identification.attribution import other_branches
from pipeclamp_identification.attribution.answer import attribution_answer
from pipeclamp_identification.attribution.attributed import Attributed
from pipeclamp_identification.attribution.compared import Compared
from pipeclamp_identification.attribution.misstated import warmth_words
from pipeclamp_identification.attribution.next_test import propose
from pipeclamp_identification.attribution.noise import likeliest_noise, misfit_noise
from pipeclamp_identification.attribution.refit import as_stated, changed
from pipeclamp_identification.attribution.repeats import repeats
from pipeclamp_identification.attribution.suspects import suspects_of, with_mounts
from pipeclamp_identification.attribution.verdict import Attribution, Candidate, _judged, attribute
from pipeclamp_identification.on_pipe.prediction import predict
from pipeclamp_identification.on_pipe.sines import PipeComparison, compare_pipe
from pipeclamp_identification.workflow.systems.next_on_pipe import after_pipe_comparison
from pipeclamp_models.pipe.description import Excitation
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp

PIPE = """
name = "symmetric"
[pipe]
outer_diameter_mm = 60.3
wall_mm = 3.91
length_m = 4.0
material = "316L"
[ends]
left = {left}
right = "pinned"
[[clamps]]
name = "clamp1"
position_m = 2.0
[damping]
ratio = 0.02
[modes]
up_to_Hz = 80
"""
MEASUREMENT = """
[[probes]]
name = "middle"
position_m = 2.0
unit = "mm"
[[responses]]
file = "sines.csv"
"""
TWO_PROBES = '[[probes]]\nname = "again"\nposition_m = 2.0\nunit = "mm"\n' + MEASUREMENT
SINES = [(f, level) for level in (1.0, 4.0) for f in np.linspace(6.0, 18.0, 13).tolist()]


@pytest.fixture(scope="module")
def measured_bench(tmp_path_factory: pytest.TempPathFactory, write_law: Callable[..., None]) -> Path:
    """The bench: not to be changed."""
    return _bench(tmp_path_factory.mktemp("bench"), write_law)


@pytest.fixture
def bench(measured_bench: Path, tmp_path: Path) -> Path:
    """The bench in a folder of its own, to be changed."""
    return shutil.copytree(measured_bench, tmp_path / "bench")


@pytest.fixture(scope="module")
def comparison(measured_bench: Path) -> PipeComparison:
    """The bench's sines compared."""
    return compare_pipe(measured_bench / "system.toml", measured_bench / "measured")


@pytest.fixture(scope="module")
def compared(comparison: PipeComparison) -> Compared:
    """The bench compared."""
    return Compared(comparison)


@pytest.fixture(scope="module")
def found(compared: Compared) -> Attribution:
    """What is wrong with the bench."""
    answer = attribute(compared)
    assert answer is not None
    return answer


def _bench(tmp_path: Path, write_law: Callable[..., None]) -> Path:
    """Make a pipe that is the same from both ends, measured in the middle; its left end is softer than stated."""
    write_law(tmp_path / "law.json", {"k10": 20.0, "k30": 4.0, "c0": 2.0, "alpha0": 0.6}, v_r=0.5)
    (tmp_path / "system.toml").write_text(shaken(amplitude_mm=1.0, frequency_Hz=12.0), encoding="utf-8")
    measured = tmp_path / "measured"
    measured.mkdir()
    (measured / "measurement.toml").write_text(MEASUREMENT, encoding="utf-8")
    head = "frequency_Hz,acceleration_m_s2,middle_real,middle_imag\n"
    (measured / "sines.csv").write_text(head + "".join(f"{f},{a},1,1\n" for f, a in SINES), encoding="utf-8")
    (tmp_path / "pipe.toml").write_text(PIPE.format(left="{ stiffness_N_mm = 150 }"), encoding="utf-8")
    true = compare_pipe(tmp_path / "system.toml", measured).prediction.response[:, 0]
    rng = np.random.default_rng(2)
    noisy = true * (1 + 0.01 * (rng.standard_normal(true.size) + 1j * rng.standard_normal(true.size)))
    rows = [f"{f},{a},{1e3 * a * x.real},{1e3 * a * x.imag}\n" for (f, a), x in zip(SINES, noisy, strict=True)]
    (measured / "sines.csv").write_text(head + "".join(rows), encoding="utf-8")
    (tmp_path / "pipe.toml").write_text(PIPE.format(left='"pinned"'), encoding="utf-8")
    return tmp_path


def test_suspects_change_nothing_at_zero_and_something_elsewhere(comparison):
    model = with_mounts(comparison.model)
    stated = predict(model, comparison.measurement, comparison.prediction)
    assert stated.response == pytest.approx(comparison.prediction.response, rel=1e-6)
    suspects = suspects_of(comparison.model, comparison.measurement.description)
    assert {suspect.id for suspect in suspects} == {
        "left.stiffness", "left.rotational", "right.stiffness", "right.rotational", "damping", "mass_per_length",
        "added_mass", "clamp1.stiffness", "clamp1.damping", "modulus", "clamp1.position", "clamps.temperature",
        "sensor:middle.gain", "sensor:middle.phase", "sensor:middle.delay", "sensor:middle.position",
        "excitation.gain", "excitation.phase", "excitation.delay", "frequency_axis",
    }  # fmt: skip
    for suspect in suspects:
        for values, same in ((tuple(0.0 for _ in suspect.lower), True), (suspect.starts[-1], False)):
            response = predict(changed(model, (suspect,), values), comparison.measurement, stated).response
            # The clamp's law doesn't follow the temperature.
            same = same or suspect.id == "clamps.temperature"
            assert np.allclose(response, stated.response, rtol=1e-6) == same, suspect.id
    nearly_rigid = changed(model, (suspects[0],), (1e-6,))
    response = predict(nearly_rigid, comparison.measurement, stated).response
    assert response == pytest.approx(stated.response, rel=1e-3)


def test_no_factor_is_sought_on_what_a_law_states_as_none(comparison):
    """Of a law without a cubic part "its cubic part 0.45 ± 7e-14 times" had been said."""
    ((temperature, ((index, clamp),)),) = comparison.model.clamps.items()

    def factors(**values):
        law = replace(clamp.law, values={**clamp.law.values, **values})
        model = replace(comparison.model, clamps={temperature: ((index, replace(clamp, law=law)),)})
        suspects = suspects_of(model, comparison.measurement.description)
        return {one.id: len(one.lower) for one in suspects if one.id in ("clamp1.stiffness", "clamp1.damping")}

    assert factors() == {"clamp1.stiffness": 2, "clamp1.damping": 1}
    assert factors(k30=0.0) == {"clamp1.stiffness": 1, "clamp1.damping": 1}
    assert factors(c0=0.0) == {"clamp1.stiffness": 2}


def test_a_compliance_that_is_hardly_told_has_no_endless_per_cent(comparison):
    suspects = suspects_of(comparison.model, comparison.measurement.description)
    (rigid,) = (one for one in suspects if one.id == "right.stiffness")
    assert "(± 20%) instead of rigid" in rigid.value_words((0.05,), (0.01,))
    assert "(to more than ± 100%) instead of rigid" in rigid.value_words((0.05,), (1e300,))


def test_what_is_but_seen_otherwise_is_not_balanced_again(comparison, monkeypatch):
    """Each derivative by a sensor's gain had cost as many forces of the clamps as one by their stiffness."""
    model = with_mounts(comparison.model)
    suspects = {one.id: one for one in suspects_of(comparison.model, comparison.measurement.description)}
    refitted = (suspects["clamp1.stiffness"], suspects["sensor:middle.gain"], suspects["sensor:middle.position"])
    values = [one.starts[-1] for one in refitted]

    def with_sensor(share):
        gain, position = (tuple(share * one for one in own) for own in values[1:])
        return changed(model, refitted, (*values[0], *gain, *position))

    stated = predict(model, comparison.measurement, comparison.prediction)
    near = predict(with_sensor(1.0), comparison.measurement, stated)
    expected = predict(with_sensor(0.5), comparison.measurement, stated).response
    counted, forces = [], SteadyClamp.forces
    monkeypatch.setattr(SteadyClamp, "forces", lambda *given: counted.append(1) or forces(*given))
    found = predict(with_sensor(0.5), comparison.measurement, near)
    assert not counted
    assert found.response == pytest.approx(expected, rel=1e-6)
    assert not np.allclose(found.response, near.response, rtol=1e-3)


def test_what_is_but_seen_otherwise_moves_as_stated(comparison):
    """No other branch is looked for there: the clamps move alike to the last digit."""
    model = with_mounts(comparison.model)
    stated = predict(model, comparison.measurement, comparison.prediction)
    alike = set()
    for suspect in suspects_of(comparison.model, comparison.measurement.description):
        other = changed(model, (suspect,), suspect.starts[-1])
        if suspect.side != "measurement":
            assert not other.moves_as(model) or suspect.id == "clamps.temperature", suspect.id
            continue
        moved = predict(other, comparison.measurement, stated).clamps
        assert other.moves_as(model) == np.allclose(moved, stated.clamps, rtol=1e-9), suspect.id
        alike |= {suspect.id} if other.moves_as(model) else set()
    assert alike == {
        *(f"sensor:middle.{what}" for what in ("gain", "phase", "delay", "position")), "excitation.phase",
        "excitation.delay",
    }  # fmt: skip


def test_a_response_is_followed_once_for_all_that_is_but_seen_otherwise(comparison, monkeypatch):
    """Each of three sensors' suspects had been followed anew, 12 s each where two clamps slip."""
    stated = replace(comparison.prediction, model=with_mounts(comparison.model))
    suspects = {one.id: one for one in suspects_of(comparison.model, comparison.measurement.description)}
    apart = (suspects["sensor:middle.position"], suspects["sensor:middle.gain"], suspects["excitation.delay"])
    models = [changed(stated.model, (one,), one.starts[-1]) for one in apart]
    expected = [predict(model, comparison.measurement).response for model in models]
    followed, follow = [], SteadySystem.path
    monkeypatch.setattr(SteadySystem, "path", lambda *given: followed.append(1) or follow(*given))
    for model, response in zip(models, expected, strict=True):
        assert predict(model, comparison.measurement, followed=stated).response == pytest.approx(response, rel=1e-6)
    assert not followed


def test_looking_for_other_branches_ends_and_says_what_was_left_out(comparison, found, monkeypatch):
    monkeypatch.setattr(other_branches, "NEAR_ENOUGH", 0.0)  # as where no refit comes near
    monkeypatch.setattr(other_branches, "MOST_FOLLOWED", 1.0)
    refits, told = [one.refit for one in found.candidates if len(one.suspects) == 1], []
    _, unseen = other_branches.on_the_nearest_branches(found.task, refits, comparison, told.append)
    assert 5 < unseen < len(refits)
    assert told[-1].startswith(f"look for other branches, {len(refits) - unseen + 1} of {len(refits)}")
    words = " ".join(attribution_words(replace(found, unseen=unseen), None))
    assert f"Whether {unseen} suspects of the worst would do better on another" in words


def test_where_a_force_acts_is_a_suspect_and_moves_the_force_alone(comparison):
    model = comparison.model
    assert not any(one.id == "excitation.position" for one in suspects_of(model, comparison.measurement.description))
    forced = replace(model, pipe=model.pipe.model_copy(update={"excitation": Excitation(kind="force", position_m=1.5)}))
    (suspect,) = (
        one for one in suspects_of(forced, comparison.measurement.description) if one.id == "excitation.position"
    )
    moved = changed(forced, (suspect,), (0.2,)).pipe
    assert moved.excitation.position_m == pytest.approx(1.7)
    assert moved.model_copy(update={"excitation": forced.pipe.excitation}) == forced.pipe
    assert suspect.lower == (-1.5,)
    assert "1.7" in suspect.value_words((0.2,), (0.01,))
    assert "instead of 1.5 m" in suspect.value_words((0.2,), (0.01,))


def test_two_ends_that_look_alike_are_ambiguous_and_a_test_is_proposed(compared, found):
    assert found.verdict == "ambiguous"
    named = {suspect.id for suspect in found.suspects}
    assert {"left.stiffness", "right.stiffness"} <= named
    proposal = propose(found, compared)
    answer = attribution_answer(found, proposal).to_dict()
    assert "pipe" in answer["sides"]
    assert answer["nrmse"]["stated"] > 3 * min(entry["nrmse"] for entry in answer["candidates"])
    if named == {"left.stiffness", "right.stiffness"}:
        assert "a probe at" in proposal.test
        assert any("it is a support's stiffness" in words for words in attribution_words(found, proposal))
    attributed = Attributed(compared, found, proposal)
    following = after_pipe_comparison(attributed, "system.toml", "measured", reported=True)
    answer, response, tried, *_ = attributed_sections(attributed, following)
    assert answer.command == "pipeclamp compare system.toml measured"
    assert answer.paragraphs[-1] == "Next, once that is measured too, run the command below."
    assert answer.paragraphs[0].startswith("Ambiguous: one of these is wrong"), "the verdict before how much it errs"
    assert response.figures and tried.title == "What was tried"
    assert "Ambiguous" in render("test", "", [answer, response, tried])


@pytest.mark.parametrize(
    ("verdict", "reported", "words"),
    [
        ("complete", False, "Next: pipeclamp cosim my.toml -o cosim.csv --report cosim.html"),
        ("wrong", False, "Next, once it is put right: pipeclamp compare my.toml measured"),
        ("ambiguous", False, "Next, once it is known which, and put right: pipeclamp compare my.toml measured"),
        ("unknown", False, "Next: pipeclamp compare my.toml measured --report compare.html"),
        ("unknown", True, "Next, once another level or probe is measured: pipeclamp compare my.toml measured"),
    ],
)
def test_each_verdict_ends_with_what_comes_next(compared, found, verdict, reported, words):
    judged = Attributed(compared, replace(found, verdict=verdict), None)
    assert after_pipe_comparison(judged, "my.toml", "measured", reported=reported).words() == words


def test_what_comes_next_where_nothing_can_be_asked_or_the_branch_is_not_known(compared, found):
    untold = replace(found, verdict="unknown", branch_unknown=True)
    unrepeated = replace(found, verdict="unknown", noise_unknown=True)
    repeated = "Next, once some sines are repeated: pipeclamp compare my.toml measured"
    swept = "Next, once it says which way it was swept: pipeclamp compare my.toml measured"
    more = "Next, once more is measured: pipeclamp compare my.toml measured"
    for judged, words in ((untold, swept), (unrepeated, repeated), (None, more)):
        following = after_pipe_comparison(Attributed(compared, judged, None), "my.toml", "measured", reported=False)
        assert following.words() == words


def test_a_temperature_that_nothing_tells_has_no_number():
    assert warmth_words((0.0,), (7e11,)) == "these measurements don't tell it"
    assert warmth_words((0.0,), (0.0,)) == "these measurements don't tell it", "no law follows it"
    assert warmth_words((12.0,), (3.0,)) == "+12 ± 3 K from what is stated"


def test_what_errs_only_where_the_branch_is_not_known_is_not_named(compared, found):
    sines = found.task.sines
    several, one = np.full(len(SINES), 2), np.ones(len(SINES), dtype=np.intp)
    few = np.where(np.arange(len(SINES)) < 3, 2, 1)
    up = replace(sines.measurement, steady=replace(sines.measurement.steady, sweep=one))
    for branches, measurement, unknown in (
        (several, sines.measurement, True),
        (several, up, False),
        (few, sines.measurement, False),
        (one, sines.measurement, False),
    ):
        evidence = replace(sines, measurement=measurement, stated=replace(sines.stated, branches=branches))
        task = replace(found.task, sines=evidence)
        judged = _judged(compared, task, list(found.candidates), found.together.refit, lambda what: None)
        assert judged.branch_unknown == unknown
        assert (judged.verdict == "unknown") == unknown
        assert any("state sweep = 'up' or 'down'" in words for words in attribution_words(judged, None)) == unknown


def test_a_rival_that_the_best_does_not_rule_out_is_named_though_it_is_not_beyond_doubt_itself(
    compared, found, monkeypatch
):
    monkeypatch.setattr("pipeclamp_identification.attribution.verdict._pairs", lambda *_: [])
    barely = found.task.sines.scaled(found.stated.refit.rms / 1.1)
    task = replace(found.task, sines=barely)
    stated = as_stated(task)
    singles = [one for one in found.candidates if len(one.suspects) == 1]

    def leaving(one: Candidate, share: float, gained: float) -> Candidate:
        residual = stated.residual * share**0.5
        return replace(one, refit=replace(one.refit, residual=residual), heldout=stated.squared - gained)

    best, rival = leaving(singles[0], 0.6, 20.0), leaving(singles[1], 0.7, 10.0)
    others = [leaving(one, 1.0, -1.0) for one in singles[2:]]
    everything = replace(found.together.refit, residual=stated.residual * 0.55**0.5)
    judged = _judged(compared, task, [best, rival, *others], everything, lambda what: None)
    assert judged.verdict == "ambiguous"
    assert judged.named == (best, rival)
    ruled_out = leaving(singles[1], 0.9, 10.0)
    judged = _judged(compared, task, [best, ruled_out, *others], everything, lambda what: None)
    assert (judged.verdict, judged.kind) == ("wrong", "cause")
    # A second parameter that a part of the sines alone tells is far off where that part is left out.
    badly_left_out = leaving(singles[1], 0.65, -1e3)
    judged = _judged(compared, task, [best, badly_left_out, *others], everything, lambda what: None)
    assert judged.named == (best, badly_left_out)


def test_what_is_left_is_no_noise_only_because_it_is_as_rough(compared, found, monkeypatch):
    """Sines far apart make any misfit rough: more than tests scatter by is noise only where repeats tell it."""
    monkeypatch.setattr("pipeclamp_identification.attribution.verdict._pairs", lambda *_: [])
    task = replace(found.task, sines=found.task.sines.scaled(found.stated.refit.rms / 2.2))
    stated = as_stated(task)

    def judged(share: float, nrmse: float) -> Attribution:
        residual = stated.residual * share**0.5
        singles = [
            replace(one, nrmse=nrmse, heldout=stated.squared - 5) for one in found.candidates if len(one.suspects) == 1
        ]
        singles = [replace(one, refit=replace(one.refit, residual=stated.residual)) for one in singles]
        best = replace(singles[0], refit=replace(singles[0].refit, residual=residual), heldout=share * stated.squared)
        everything = replace(found.together.refit, residual=0.98 * residual)
        return _judged(compared, task, [best, *singles[1:]], everything, lambda what: None)

    assert compared.sines.noise_nrmse is None
    assert (judged(0.16, 0.09).verdict, judged(0.16, 0.09).kind) == ("wrong", "cause")
    part = judged(0.16, 0.5)
    assert (part.verdict, part.kind, part.noise_unknown) == ("wrong", "part", True)
    words = attribution_words(part, None)
    assert words[0].startswith("Part of what is wrong")
    assert any("Only repeated sines tell whether it is noise" in one for one in words)
    assert judged(0.31, 0.09).kind == "cause"
    assert judged(0.31, 0.5).verdict == "unknown", "it takes less than seven tenths of all that is wrong"
    monkeypatch.setattr(PipeComparison, "noise_nrmse", 0.5)
    assert judged(0.16, 0.5).kind == "cause"


def test_a_proposed_test_may_have_fewer_probes_than_the_measurement(bench, found):
    measured = bench / "measured" / "sines.csv"
    head, *rows = measured.read_text(encoding="utf-8").splitlines()
    twice = [f"{row},{','.join(row.split(',')[2:])}" for row in rows]
    measured.write_text("\n".join([f"{head},again_real,again_imag", *twice]) + "\n", encoding="utf-8")
    (bench / "measured" / "measurement.toml").write_text(TWO_PROBES, encoding="utf-8")
    compared = Compared(compare_pipe(bench / "system.toml", bench / "measured"))
    assert len(compared.model.pipe.probes) == 2
    task = replace(found.task, model=with_mounts(compared.model))
    assert propose(replace(found, task=task, named=found.named[:2]), compared) is not None


def test_roughness_tells_the_noise_whatever_the_misfit(comparison):
    response = comparison.measurement.steady.response
    smooth = 1.1 * predict(comparison.model, comparison.measurement, comparison.prediction).response
    rng = np.random.default_rng(3)
    noise = 0.02 * np.abs(smooth) * (rng.standard_normal(smooth.shape) + 1j * rng.standard_normal(smooth.shape))
    measured = replace(comparison.measurement.steady, response=smooth + noise)
    found = misfit_noise(replace(comparison.measurement, steady=measured), smooth / 1.1)
    assert found is not None and found.shape == response.shape
    assert float(np.median(found / np.abs(smooth))) == pytest.approx(0.02, rel=0.35)


def test_how_many_repeats_would_tell_follows_from_how_far_apart_the_explanations_are(found):
    best = found.named[0]
    there = best.refit.residual / best.overdispersion**0.5

    def beside(apart: float) -> Attribution:
        one = replace(best, refit=replace(best.refit, residual=there))
        away = there + apart * np.eye(there.size)[0]
        return replace(found, named=(one, replace(one, refit=replace(one.refit, residual=away))))

    twice, often = repeats(beside(4.0)), repeats(beside(2.0))
    assert twice is not None and often is not None
    assert (twice.times, often.times) == (2, 7)  # 5.2 standard deviations are asked for
    assert "Measure the same 7 times, or with 2.6 times less noise" in often.words()
    assert repeats(beside(0.4)) is None


def test_what_a_true_model_leaves_tells_the_noise_better_than_its_roughness(comparison):
    measurement, computed = comparison.measurement, comparison.prediction.response
    rng = np.random.default_rng(4)
    ratios = []
    for _ in range(40):
        error = rng.standard_normal(computed.shape) + 1j * rng.standard_normal(computed.shape)
        noisy = computed + 0.02 * np.abs(computed) * error
        drawn = replace(measurement, steady=replace(measurement.steady, response=noisy))
        size = 0.02 * np.abs(noisy)
        ratios.append(
            [np.median(misfit_noise(drawn, computed) / size), np.median(likeliest_noise(drawn, computed, 0) / size)]
        )
    (_, likeliest), (rough_spread, spread) = np.mean(ratios, axis=0), np.std(ratios, axis=0)
    assert likeliest == pytest.approx(1.0, abs=0.05)
    assert spread < 0.8 * rough_spread


def test_too_few_values_are_not_asked(bench):
    measured = bench / "measured" / "sines.csv"
    lines = measured.read_text(encoding="utf-8").splitlines()
    measured.write_text("\n".join(lines[:8]) + "\n", encoding="utf-8")
    found = attribute(Compared(compare_pipe(bench / "system.toml", bench / "measured")))
    assert found is None
    assert "at least" in attribution_words(found, None)[0]
