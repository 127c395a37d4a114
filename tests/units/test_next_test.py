"""The next test: rivals that a narrow campaign can't tell apart, and the test that does."""

from dataclasses import replace

import numpy as np
import pytest

from pipeclamp.bundled import open_law
from pipeclamp.parameter_file import law_of
from pipeclamp_identification import rig
from pipeclamp_identification.campaign import read_campaign
from pipeclamp_identification.campaign_writing import joined_runs, write_campaign
from pipeclamp_identification.diagnosis_report import answer_for, answer_sections
from pipeclamp_identification.identify import identify, law_file
from pipeclamp_identification.next_test import RIDDEN, RIDING, RIDING_ORDER, next_test, parse_limits
from pipeclamp_identification.report import render

NARROW = rig.TestPlan((0.3, 0.6, 1.0), (3.0, 4.0), (20.0,), cycles=3.0, rate=240.0, force_noise=8.0)
"""Two neighbouring frequencies: the stiffness that follows f could as well be inertia."""


@pytest.fixture(scope="module")
def virtual(tmp_path_factory):
    """Give a virtual campaign of the bundled law."""

    def made(plan, seed=0):
        folder = tmp_path_factory.mktemp("next") / f"campaign{seed}"
        runs = rig.virtual_runs(law_of(open_law("emwm2")), replace(plan, seed=seed))
        write_campaign(folder, runs, name=folder.name, notes="")
        return read_campaign(folder)

    return made


@pytest.fixture(scope="module")
def narrow(virtual):
    return virtual(NARROW)


@pytest.fixture(scope="module")
def law(narrow):
    return law_file(identify(narrow), narrow, name="law", command="test", date=None)


@pytest.fixture(scope="module")
def answer(narrow, law):
    return answer_for(law, narrow, limits=parse_limits("A=0.1..1.5,f=0.5..20,T=20..20"))


def test_the_proposed_test_settles_it(virtual, narrow, law, answer, tmp_path):
    assert answer.verdict == "ambiguous"
    assert set(answer.diagnosis.effects) == {"stiffness_frequency", "inertia"}
    proposal = answer.proposal
    plan = replace(
        NARROW, amplitudes=(proposal.amplitude_mm,), frequencies=(proposal.frequency_Hz,),
        temperatures=(proposal.temperature_C,), riding=RIDING if proposal.profile == RIDDEN else 0.0,
        riding_order=RIDING_ORDER, rate=max(240.0, 160 * proposal.frequency_Hz),
    )  # fmt: skip
    campaigns = [narrow, *(virtual(plan, seed) for seed in (1, 2, 3))]
    write_campaign(tmp_path / "all", joined_runs(campaigns), name="all", notes="")
    settled = answer_for(law, read_campaign(tmp_path / "all")).diagnosis
    assert (settled.verdict, settled.effects) == ("missing", ("stiffness_frequency",))


def test_each_rivals_loop_is_drawn(answer):
    proposal = answer.proposal
    assert proposal.rivals == answer.diagnosis.effects
    assert proposal.forces.shape == (2, proposal.motion.y.shape[1])
    assert proposal.separation > 1.0
    page = render("t", "s", answer_sections(answer))
    assert all(f"if it is {name}" in page for name in proposal.rivals)


@pytest.mark.parametrize("stated", ["A=0.2..0.4,f=5..6,T=20..20", "A=2..3,f=0.5..1,T=100..200"])
def test_a_proposal_stays_within_the_rigs_limits(answer, stated):
    limits = parse_limits(stated)
    proposal = next_test(answer.diagnosis, limits)
    for value, (low, high) in (
        (proposal.amplitude_mm, limits.amplitude),
        (proposal.frequency_Hz, limits.frequency),
        (proposal.temperature_C, limits.temperature),
    ):
        assert low * (1 - 1e-9) <= value <= high * (1 + 1e-9)
    assert np.isfinite(proposal.separation)


def test_no_temperature_is_made_up_where_the_tests_have_none(narrow, law, answer):
    """Not the assumed one, and not one within the rig's limits either; else it is the same proposal."""
    bare = replace(narrow, runs=tuple(replace(run, temperature_C=None) for run in narrow.runs))
    diagnosis = answer_for(law, bare, limits=parse_limits("A=0.1..1.5,f=0.5..20,T=100..200")).diagnosis
    for limits in (None, parse_limits("A=0.1..1.5,f=0.5..20,T=100..200")):
        proposal = next_test(diagnosis, limits)
        assert proposal.temperature_C is None
        assert "Hz, the temperature of the tests so far, " in proposal.words()
        assert "degC" not in proposal.words()
        assert set(proposal.motion.slow["T"].ravel()) == {293.15}
    assert proposal.amplitude_mm == pytest.approx(answer.proposal.amplitude_mm)
    assert proposal.frequency_Hz == pytest.approx(answer.proposal.frequency_Hz)
