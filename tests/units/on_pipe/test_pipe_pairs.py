"""Two things wrong at once are both tried: one that looks like them isn't named for them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from project import PIPE_TRUTH

from pipeclamp.show.on_pipe import attribution_words
from pipeclamp_identification.attribution.compared import compare_measured
from pipeclamp_identification.attribution.pairs import promised_pairs, refitted_pairs
from pipeclamp_identification.attribution.suspect import Suspect
from pipeclamp_identification.attribution.verdict import Attribution, attribute

TRUTH = {"support:2.9.stiffness", "added_mass"}
NOISE = 0.01
PARTS = ("real", "imag")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Attribution:
    """A softer support and a mass together, under weak drive, by harmonic balance, with noise."""
    folder = tmp_path_factory.mktemp("two")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(PIPE_TRUTH)
        from designs import MASS
        from measuring_trials import MEASURING_DESIGNS
        from pipe_rig import describe

        design = MEASURING_DESIGNS["line weak"]
        stated = design.write(folder, {}, {})
        true = design.write(folder / "true", {"support": 8.0, "further": MASS.format(3.3, 1.0)}, {})
        measured = folder / "measured"
        measured.mkdir()
        describe(measured, design.sensors, '[[responses]]\nfile = "sines.csv"\n')
    names = [sensor.name for sensor in design.sensors]
    head = ",".join(["frequency_Hz", "acceleration_m_s2", *(f"{name}_{part}" for name in names for part in PARTS)])

    def write(rows: np.ndarray) -> None:
        np.savetxt(measured / "sines.csv", rows, delimiter=",", header=head, comments="")

    driven = np.array([(sine.frequency, sine.drive) for sine in design.sines])
    write(np.column_stack([driven, *[np.ones(len(driven))] * 2 * len(names)]))
    sines = compare_measured(true, measured).sines
    assert sines
    scale = np.array([probe.scale for probe in sines.measurement.description.probes])
    exact = sines.prediction.response * driven[:, 1:] / scale
    rng = np.random.default_rng(7)
    size = NOISE * (np.abs(exact) + 0.1 * np.abs(exact).max(axis=0))
    seen = exact + size * (rng.standard_normal(exact.shape) + 1j * rng.standard_normal(exact.shape))
    write(np.column_stack([driven, *(part for column in seen.T for part in (column.real, column.imag))]))
    answer = attribute(compare_measured(stated, measured))
    assert answer is not None
    return answer


def test_two_faults_together_are_not_taken_for_one_that_looks_like_them(found):
    alone = next(one for one in found.candidates if [suspect.id for suspect in one.suspects] == ["added_mass"])
    assert alone.nrmse < 0.1 * found.stated.nrmse, "one alone explains nearly all of it"
    assert found.verdict in ("wrong", "ambiguous")
    assert found.kind == "cause"
    assert TRUTH in [{suspect.id for suspect in one.suspects} for one in found.named]


def test_a_position_has_several_valleys_and_the_deepest_is_found(found):
    singles = sorted((one.refit for one in found.candidates if len(one.suspects) == 1), key=lambda refit: refit.squared)
    promised = promised_pairs(found.task, singles)
    assert [pair.squared for pair in promised] == sorted(pair.squared for pair in promised)
    starts = [pair.start.values[-1] for pair in promised if pair.start.suspects[1].id == "added_mass"]
    assert len(set(starts)) > 1
    of_truth = [pair for pair in promised if pair.ids == TRUTH]
    (best,) = refitted_pairs(found.task, of_truth, 0.0)
    assert best.values_of(_suspect(found, "added_mass"))[1] * 4.0 == pytest.approx(3.3, abs=0.4)


def test_a_part_is_said_to_be_one(found):
    part = replace(found, verdict="wrong", named=found.named[:1], kind="part")
    words = attribution_words(part, None)
    assert words[0].startswith("Part of what is wrong: ")
    assert any("a part is no proof" in sentence.lower() for sentence in words)
    several = replace(found, verdict="ambiguous", named=found.candidates[:2], kind="part")
    assert "one of these is part of what is wrong" in attribution_words(several, None)[0]


def _suspect(found: Attribution, name: str) -> Suspect:
    return next(suspect for one in found.candidates for suspect in one.suspects if suspect.id == name)
