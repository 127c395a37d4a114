"""The next test: rivals that a narrow campaign can't tell apart, and the test that does."""

import re
from dataclasses import replace

import numpy as np
import pytest

from pipeclamp.pages.diagnosis import evidence_sections
from pipeclamp.pages.page import render
from pipeclamp.show.diagnosis import next_test_lines
from pipeclamp_identification.campaign.drive import FULL_CYCLES, RAMP_CYCLES, drive_content, read_drive
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.plan import driven
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import joined_runs, write_campaign
from pipeclamp_identification.diagnosis.diagnosed import diagnosed
from pipeclamp_identification.diagnosis.further_test.limits import parse_limits
from pipeclamp_identification.diagnosis.further_test.next_test import NoTest, Proposal, next_test
from pipeclamp_identification.diagnosis.further_test.outlook import RIDDEN, RUNS_OF_A_TEST
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import Provenance, law_of

NARROW = Plan((0.3, 0.6, 1.0), (3.0, 4.0), (20.0,), cycles=3.0, rate=240.0, force_noise=8.0)
"""Two neighbouring frequencies: the stiffness that follows f could as well be inertia."""


@pytest.fixture(scope="module")
def virtual(tmp_path_factory):
    """Give a virtual campaign of the bundled law."""

    def made(plan, seed=0):
        folder = tmp_path_factory.mktemp("next") / f"campaign{seed}"
        runs = virtual_runs(law_of(open_law("emwm2")), replace(plan, seed=seed))
        write_campaign(folder, runs, name=folder.name, notes="")
        return read_campaign(folder)

    return made


@pytest.fixture(scope="module")
def narrow(virtual):
    return virtual(NARROW)


@pytest.fixture(scope="module")
def law(narrow):
    return law_file(identify(narrow), narrow, name="law", provenance=Provenance("test"))


@pytest.fixture(scope="module")
def answer(narrow, law):
    return diagnosed(law, narrow, limits=parse_limits("A=0.1..1.5,f=0.5..20,T=20..20"))


def test_the_proposed_test_tells_the_rivals_apart(virtual, narrow, law, answer, tmp_path):
    assert answer.verdict == "ambiguous"
    # of inertia, a special case of it, and a rival, an inner mass is a rival too
    assert set(answer.diagnosis.effects) == {"stiffness_frequency", "inertia", "inner_mass"}
    path = tmp_path / "drive.csv"
    path.write_bytes(drive_content(answer.proposal.plan.signal(), path))
    plan = driven(replace(NARROW, rate=1000.0, repeats=RUNS_OF_A_TEST), read_drive(path))
    write_campaign(tmp_path / "all", joined_runs([narrow, virtual(plan, 1)]), name="all", notes="")
    settled = diagnosed(law, read_campaign(tmp_path / "all")).diagnosis
    assert settled.effects[0] == "stiffness_frequency"
    assert not {"inertia", "inner_mass"} & set(settled.effects)


def test_each_rivals_loop_is_drawn(answer):
    proposal = answer.proposal
    assert proposal.rivals == answer.diagnosis.effects
    assert proposal.forces.shape == (3, proposal.motion.y.shape[1])
    assert proposal.separation > 1.0
    page = render("t", "s", evidence_sections(answer))
    assert all(f"if it is {name}" in page for name in proposal.rivals)


def kept(proposal, limits):
    """Hold limits against the whole motion of a proposed test: what its signal does, and what its rivals foretell."""
    drive = proposal.plan.signal()
    y, time = drive.displacement_mm, drive.time_s
    hair = 1e-6
    assert np.max(np.abs(y)) <= limits.amplitude[1] * (1 + hair)
    assert np.max(np.abs(np.diff(y) / np.diff(time))) <= limits.velocity * (1 + hair)
    # the tones, at full amplitude: whole cycles have their lines alone
    profile = proposal.plan.profile
    begin, end = (cycles * profile.samples_per_cycle for cycles in (RAMP_CYCLES, RAMP_CYCLES + FULL_CYCLES))
    lines = np.abs(np.fft.rfft(y[begin:end]))
    tones = np.flatnonzero(lines > 1e-3 * lines.max()) * proposal.frequency_Hz / FULL_CYCLES
    assert limits.frequency[0] * (1 - hair) <= tones.min()
    assert tones.max() <= limits.frequency[1] * (1 + hair)
    assert proposal.amplitude_mm >= limits.amplitude[0] * (1 - hair)
    assert limits.temperature[0] - hair <= proposal.temperature_C <= limits.temperature[1] + hair
    assert np.max(np.abs(proposal.forces)) <= limits.force * (1 + hair)
    return tones


@pytest.mark.parametrize("stated", ["A=0.2..0.4,f=5..6,T=20..20", "A=1..1.2,f=0.5..1,T=15..25"])
def test_a_proposal_stays_within_the_rigs_limits(answer, stated):
    proposal = next_test(answer.diagnosis, parse_limits(stated))
    kept(proposal, parse_limits(stated))
    assert np.isfinite(proposal.separation)


def test_cycles_that_ride_stay_within_the_limits_too(answer):
    """It had proposed 1 mm at 3 Hz with a ripple at 21 Hz, which peaks at 1.25 mm."""
    limits = parse_limits("A=0.1..1.1,f=0.5..8,T=20..20")
    proposal = next_test(answer.diagnosis, limits)
    tones = kept(proposal, limits)
    assert proposal.profile == RIDDEN
    assert tones.max() == pytest.approx(7 * proposal.frequency_Hz)


def test_the_velocity_bounds_the_test(answer):
    free = next_test(answer.diagnosis, parse_limits("A=0.1..1.5,f=0.5..20"))
    assert free.plan.peak_velocity > 3.0
    slow = parse_limits("A=0.1..1.5,f=0.5..20,v=..3")
    kept(next_test(answer.diagnosis, slow), slow)


def test_where_no_test_tells_it_is_said_which_limit_would_have_to_give(answer):
    told = next_test(answer.diagnosis, parse_limits("A=0.3..0.31,f=3.4..3.6,T=20..20"))
    assert isinstance(told, NoTest)
    assert "tells any two of stiffness_frequency, inertia, inner_mass apart" in told.words
    lowest = re.search(r"it would take .*f=([\d.]+)\.\.", told.words)
    assert isinstance(next_test(answer.diagnosis, parse_limits(f"A=0.3..0.31,f={lowest[1]}..3.6,T=20..20")), Proposal)


def test_limits_that_no_motion_keeps(answer):
    told = next_test(answer.diagnosis, parse_limits("A=1..1.5,f=3..8,v=..10"))
    assert "no motion keeps all of A=1..1.5,f=3..8,T=20..20,v=..10; it would take" in told.words
    assert float(re.search(r"take .*v=\.\.([\d.]+)", told.words)[1]) > 2 * np.pi * 1.0 * 3.0
    assert "F=.." in next_test(answer.diagnosis, parse_limits("F=..100")).words


def test_the_drive_is_drawn_and_named(answer, tmp_path):
    (section,) = [section for section in evidence_sections(answer) if section.title == "Next test"]
    assert "6 at full amplitude" in " ".join(section.paragraphs)
    lines = next_test_lines(answer, tmp_path / "drive.csv")
    assert "drive.csv holds its drive signal" in lines[1]
    assert "`pipeclamp import` makes next_test of its records" in lines[2], "which the next line joins"
    assert re.search(r"can't tell \w+(, \w+)* and \w+ apart", " ".join(answer.words()))
    assert "--drive DRIVE.csv writes" in next_test_lines(answer, None)[1]
    none = next_test_lines(replace(answer, limits=parse_limits("F=..100")), tmp_path / "drive.csv")
    assert none[0].startswith("No next test: ")
    assert none[1] == f"{tmp_path / 'drive.csv'} isn't written: no test is proposed"


def test_no_temperature_is_made_up_where_the_tests_have_none(narrow, law, answer):
    """Not the assumed one, and not one within the rig's limits either; else it is the same proposal."""
    bare = replace(
        narrow, runs=tuple(replace(run, setup=replace(run.setup, temperature_C=None)) for run in narrow.runs)
    )
    diagnosis = diagnosed(law, bare, limits=parse_limits("A=0.1..1.5,f=0.5..20,T=100..200")).diagnosis
    for limits in (None, parse_limits("A=0.1..1.5,f=0.5..20,T=100..200")):
        proposal = next_test(diagnosis, limits)
        assert proposal.temperature_C is None
        assert "Hz, the temperature of the tests so far, " in proposal.words()
        assert "°C" not in proposal.words()
        assert set(proposal.motion.slow["T"].ravel()) == {293.15}
    assert proposal.amplitude_mm == pytest.approx(answer.proposal.amplitude_mm)
    assert proposal.frequency_Hz == pytest.approx(answer.proposal.frequency_Hz)
