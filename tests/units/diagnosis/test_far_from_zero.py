"""Tests that move far from the displacement's zero, as of a part under its load: fits begin where they move."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from few_effects import few_effects

import pipeclamp as pc
from pipeclamp_fmu.build import creates_energy
from pipeclamp_fmu.contents.clamp import quantities
from pipeclamp_fmu.contents.clamp_of_law import clamp_model
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.discovery.proposal import formula_of, toml_of
from pipeclamp_identification.discovery.telling import telling_test
from pipeclamp_identification.fitting.observations import data_scales, loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_identification.planning.hidden import bare_law, law_of_size, peak_forces
from pipeclamp_models.law.file import law_of
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

RIVALS = "asymmetry", "end_stop", "exponential_stiffening", "gas_spring", "unilateral_contact"
AMPLITUDES = (1.0, 2.0, 3.0, 4.0, 5.0)


def buffered(y, v):
    """A spring and a dashpot with a rubber buffer at 86.5 mm."""
    return 30 * y + 0.6 * v + 60 * np.maximum(y - 86.5, 0.0) ** 1.5


def stopped(y, v):
    """The same with a second spring from 87 mm on."""
    return 30 * y + 0.6 * v + 80 * np.maximum(y - 87.0, 0.0)


def compressed(y, v):
    """Gas in a column of 160 mm."""
    return 30 * y + 0.6 * v + 4000 * ((1 - y / 160) ** -1.3 - 1)


def moved_about(folder, place, force):
    rng = np.random.default_rng(4)
    runs = []
    for A in AMPLITUDES:
        for f in (0.5, 2.0):
            time = np.arange(400) / (100 * f)
            y, v = place + A * np.sin(2 * np.pi * f * time), 2 * np.pi * f * A * np.cos(2 * np.pi * f * time)
            F = force(y, v)
            F += rng.normal(0, 0.003 * np.std(F), len(F))
            runs.append(WrittenRun({"run": f"A{A:g}_f{f:g}", "amplitude_mm": A, "frequency_Hz": f}, Record(time, y, F)))
    write_campaign(folder, iter(runs), name="far", notes="")
    return pc.read_campaign(folder)


@pytest.mark.parametrize(
    ("force", "effect", "found"),
    [
        (buffered, "unilateral_contact", {"F_h": 60.0, "y_h": 86.5}),
        (stopped, "end_stop", {"k_e": 80.0, "y_e": 87.0}),
        (compressed, "gas_spring", {"q_g": 1 / 160}),
    ],
)
def test_an_effect_of_where_the_motion_is_fits_tests_about_85_mm(tmp_path, force, effect, found):
    """Stops had been sought within 5 mm of zero, as far as the largest amplitude goes: the law erred by 26 and 33 %."""
    tests = moved_about(tmp_path / "c", 85.0, force)
    law = pc.identify(tests, effects=(effect,)).file
    values = {name: law.coefficients[name].value for name in found}
    assert values == pytest.approx(found, rel=0.02)


def test_the_cause_of_tests_about_85_mm_is_named(tmp_path):
    """An `asymmetry` had been named, a part, "and no rival comes near"."""
    tests = moved_about(tmp_path / "c", 85.0, buffered)
    with few_effects(*RIVALS):
        answer = pc.diagnose(pc.identify(tests), tests)
    assert (answer.verdict, answer.effects) == ("missing", ("unilateral_contact",))


def test_tests_about_zero_have_the_sizes_of_their_largest_amplitude(tmp_path):
    moved_about(tmp_path / "c", 0.0, buffered)
    sizes = data_scales(loop_observations(loops_of(read_campaign(tmp_path / "c"))))
    assert sizes["y_reach"] == pytest.approx(sizes["A_highest"], rel=1e-3)
    assert sizes["y_middle"] == pytest.approx(0.0, abs=1e-3)


def test_a_law_of_tests_about_85_mm_is_told_where_they_moved(tmp_path):
    """Its stiffness had been told at 0 mm, 15.000 ± 0.006 N/mm, where no test was."""
    tests = moved_about(tmp_path / "c", 85.0, lambda y, v: 15 * y + 0.6 * v + 1e-4 * y**3)
    law = pc.identify(tests)
    assert law.file.data.about_mm == pytest.approx(85.0, rel=1e-3)
    words = str(law)
    assert "about 85 mm" in words
    clamp = clamp_model(law.file)
    assert any("Its tests moved about 85 mm" in note for note in clamp.notes)
    place = quantities(clamp)["flange.s"]
    assert (place.minimum <= 0.0, place.maximum > 0.09, place.nominal) == (True, True, 0.09)
    told = float(re.search(r"Hz\): ([\d.]+) ", words).group(1))
    # damping makes the stored energy a little larger
    assert told == pytest.approx(15 + 3e-4 * 85**2, rel=0.04)


def test_the_next_test_is_sought_where_the_tests_moved(tmp_path):
    tests = moved_about(tmp_path / "c", 85.0, stopped)
    with few_effects(*RIVALS):
        answer = pc.diagnose(pc.identify(tests), tests)
    assert (answer.verdict, set(answer.effects)) == ("ambiguous", {"end_stop", "unilateral_contact"})
    assert "mm about 85 mm, as the tests so far" in str(answer) and "T=20..20" not in str(answer)


def test_where_the_error_sits_is_told_by_the_middle_of_the_motion(tmp_path):
    """Of tests between 80 and 90 mm it had been said to sit "at negative displacement"."""
    tests = moved_about(tmp_path / "c", 85.0, lambda y, v: 15 * y + 0.6 * v + 60 * np.maximum(82.0 - y, 0.0) ** 1.5)
    words = str(pc.compare(pc.identify(tests), tests))
    assert "below the middle of the motion" in words and "negative displacement" not in words


def test_a_load_beside_the_spring_is_named_in_tests_about_85_mm(tmp_path):
    """The stiffness had carried it by exponents of the amplitude, and a load cell that gives 3 % less was suspected."""
    tests = moved_about(tmp_path / "c", 85.0, lambda y, v: buffered(y, v) - 1050.0)
    law = pc.identify(tests, effects=("unilateral_contact",))
    with few_effects("offset", *RIVALS):
        answer = pc.diagnose(law, tests)
    assert (answer.verdict, answer.effects) == ("missing", ("offset",))


def test_a_contact_within_the_first_half_of_a_one_sided_test_is_found(tmp_path):
    """A linkage that grows taut at 6.6 mm of 25: a start from the middle of the way ended beside it, at 8.7 % error."""
    tests = moved_about(tmp_path / "c", 5.1, lambda y, v: 2 * y + 0.3 * v + 20 * np.maximum(y - 2.6, 0.0))
    law = pc.identify(tests, effects=("unilateral_contact",)).file
    assert law.coefficients["y_h"].value == pytest.approx(2.6, rel=0.02)


def test_a_term_of_the_grammar_counts_from_where_the_tests_moved(tmp_path):
    """A place within 15 mm of zero had been all that `discover` could write."""
    tests = moved_about(tmp_path / "c", 85.0, lambda y, v: 30 * y + 0.6 * v + 1.5 * v * np.maximum(y - 86.5, 0.0))
    beyond = "found_viscous_damping_positive_side"
    (term,) = (one for one in terms(("A", "f"), {}, 85.0) if one.declaration.id == beyond)
    assert formula_of(term.declaration).endswith("y counted from 85 mm")
    (tmp_path / "term.toml").write_text(toml_of(term.declaration), encoding="utf-8")
    law = pc.add(pc.identify(tests), tmp_path / "term.toml", tests)
    values = {name: entry.value for name, entry in law.file.coefficients.items()}
    assert (values["F_x"], values["y_x"]) == pytest.approx((1.5, 1.5), rel=0.02)


RISING = """
id = "rising"
title = "damping that rises"
looks_like = "the loop is wider above"
force = "c_r * v * (y - y_n)"
parameters = [
    { symbol = "c_r", unit = "N s/mm2", meaning = "rate of damping", start = 0.1 },
    { symbol = "y_n", unit = "mm", meaning = "place without any", start = 78.0 },
]
"""


def test_a_law_is_asked_for_energy_where_its_tests_moved(tmp_path):
    """Its damping drives below 79 mm: no motion about 85 mm gets there, all about zero do."""
    tests = moved_about(tmp_path / "c", 85.0, lambda y, v: 30 * y + 0.2 * v * (y - 79.0))
    (tmp_path / "rising.toml").write_text(RISING, encoding="utf-8")
    file = pc.add(pc.identify(tests), tmp_path / "rising.toml", tests).file
    about_zero = file.model_copy(update={"data": file.data.model_copy(update={"about_mm": None})})
    assert [not creates_energy(one) for one in (file, about_zero)] == [True, False]


def test_what_tells_two_terms_apart_is_sought_where_the_tests_moved(tmp_path):
    """Two that differ from 86 mm on had been held against each other about zero, where neither acts."""
    tests = moved_about(tmp_path / "c", 85.0, stopped)
    law = law_of(pc.identify(tests, effects=("end_stop",)).file)
    one, other = (replace(law, values={**law.values, "k_e": stiffness}) for stiffness in (50.0, 90.0))
    assert "there they differ by" in telling_test(one, other, loops_of(read_campaign(tmp_path / "c")))


def test_a_plan_assesses_a_law_where_its_tests_moved(tmp_path):
    """About zero the spring holds 150 N at most, where the part holds 2.5 kN; and no stop is reached."""
    file = pc.identify(moved_about(tmp_path / "c", 85.0, lambda y, v: 30 * y + 0.6 * v)).file
    grid = {"A": np.array([1.0, 5.0]), "f": np.array([1.0, 1.0]), "T": np.full(2, 293.15)}
    assert peak_forces(file, grid) == pytest.approx(2 * 30 * 85, rel=0.01)
    stop = law_of_size(file, "end_stop", 6.0, grid)
    assert 85 < stop.values["y_e"] < 90
    motion = sinusoids(*grid.values(), about=85.0)
    beyond = force_of_law(stop, motion).force - force_of_law(bare_law(file), motion).force
    assert np.sqrt(np.mean(beyond**2)) == pytest.approx(6.0, rel=0.05)


def test_a_virtual_rig_moves_where_the_tests_of_its_law_did(tmp_path):
    law = pc.identify(moved_about(tmp_path / "c", 85.0, lambda y, v: 30 * y + 0.6 * v))

    def middle(name, **settings):
        plan = {"amplitudes": [2.0], "frequencies": [1.0], "temperatures": [20.0], "rate": 200, **settings}
        (run,) = read_campaign(pc.rig(law, tmp_path / name, **plan).folder).runs
        y = run.record.displacement_mm
        return np.ptp(y) / 2, np.mean(y), np.mean(run.record.force_N)

    assert middle("there") == pytest.approx((2.0, 85.0, 30 * 85), rel=0.02)
    assert middle("elsewhere", about=10.0) == pytest.approx((2.0, 10.0, 300.0), rel=0.02)
