"""What a law leaves over beyond the harmonics that loops keep: told from samples, cycle against cycle."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.diagnosis import elsewhere, verdict
from pipeclamp_identification.diagnosis.beyond_harmonics import BeyondHarmonics, beyond_harmonics
from pipeclamp_identification.diagnosis.foretold import ErrorBeyondScatter
from pipeclamp_identification.diagnosis.thresholds import FORM_NOISE_SHARE
from pipeclamp_identification.diagnosis.weighing import weigh as weighing
from pipeclamp_identification.diagnosis.weighing.scales import nothing_named
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Law, Structure

SLOWEST = 2 * np.pi * 0.5
"""Peak velocity of the slowest of the tests, mm/s."""
BASE = dict.fromkeys(("k1_A", "k1_T", "k30", "k3_A", "k3_T", "c0", "c_A", "c_f", "alpha_A", "alpha_f"), 0.0)


@pytest.fixture
def tests(run_of, campaign_of):
    """Give a function that makes tests of a spring with friction 40 tanh(v/within), of so many cycles."""

    def made(within, cycles=5.3, spikes=False):
        random = np.random.default_rng(7)
        runs = []
        for A, f in ((0.5, 1.0), (1.0, 1.0), (0.5, 3.0), (1.0, 3.0)):
            theta = 2 * np.pi * f * (time := np.arange(round(cycles / f * 500)) / 500)
            y, v = A * np.cos(theta), -2 * np.pi * f * A * np.sin(theta)
            force = 200 * y + 40 * np.tanh(v / max(within, 1e-9)) + 0.5 * random.standard_normal(len(time))
            force += 6.0 * spikes * (random.uniform(size=len(time)) < 0.02)
            runs.append(run_of(Record(time, y, force), f"A{A:g}_f{f:g}".replace(".", "p"), amplitude_mm=A))
        return campaign_of(*runs), loops_of(campaign_of(*runs))

    return made


def law_of(effect, v_r=0.01 * SLOWEST, **values):
    return Law(Structure("power", (effect,)), {"k10": 200.0, "alpha0": 1.0, **BASE, **values}, v_r, 0.005)


@pytest.mark.parametrize(("v_t", "told"), [(0.2 * SLOWEST, False), (0.05 * SLOWEST, True), (0.4 * SLOWEST, True)])
def test_friction_that_turns_over_otherwise_is_told_with_its_place(tests, v_t, told):
    found = beyond_harmonics(law_of("rounded_friction", F_t=40.0, v_t=v_t), *tests(0.2 * SLOWEST))
    assert (found.sure_share > FORM_NOISE_SHARE) == told
    if told:
        assert found.where[0] in ("near the reversals", "just after the reversals", "just before the reversals")
        assert f"{found.rms:.3g} N that repeat with each cycle" in found.words()
    else:
        assert found.share < 0.2


def test_what_does_not_repeat_is_scatter(tests):
    law = law_of("rounded_friction", F_t=40.0, v_t=0.2 * SLOWEST)
    assert beyond_harmonics(law, *tests(0.2 * SLOWEST, spikes=True)).sure_share < 0.3


def test_a_single_cycle_tells_nothing(tests):
    law = law_of("rounded_friction", F_t=40.0, v_t=0.05 * SLOWEST)
    assert beyond_harmonics(law, *tests(0.2 * SLOWEST, cycles=1.05)).share == 0.0


@pytest.mark.parametrize(("v_r", "told"), [(0.01, False), (0.2, True)])
def test_the_smoothing_of_dry_friction_is_no_physics(tests, v_r, told):
    """Friction that steps at once is a law's with its smoothing of a hundredth; more than a tenth of it isn't."""
    found = beyond_harmonics(law_of("coulomb", v_r * SLOWEST, F_c=40.0), *tests(0.0))
    assert (found.sure_share > FORM_NOISE_SHARE) == told


@pytest.mark.parametrize(
    ("share", "taking", "ends"), [(0.7, True, "complete"), (0.8, False, "unknown"), (0.8, True, "missing")]
)
def test_a_law_that_errs_beyond_the_harmonics_is_not_complete(tests, monkeypatch, share, taking, ends):
    """The friction that it lacks takes a part, and is named; where nothing does, that it errs is all that is known."""
    beyond = BeyondHarmonics(2.0, 1.0, share, ("near the reversals",))
    monkeypatch.setattr(elsewhere, "beyond_harmonics", lambda law, campaign, loops: beyond)
    monkeypatch.setattr(elsewhere, "foretold", lambda law, problem: ErrorBeyondScatter(0.0, 0.0, 0.0))
    monkeypatch.setattr(verdict, "weigh", lambda *given: nothing_named("complete", "what is left is scatter"))
    if not taking:
        monkeypatch.setattr(weighing, "able_to_take_a_part", lambda scales: [])
    found = verdict.diagnose(Structure("power"), *tests(0.2 * SLOWEST))
    assert found.verdict == ends
    assert found.effects == (("rounded_friction",) if ends == "missing" else ())
    assert found.reasons[-1] == ("what is left is scatter" if ends == "complete" else beyond.words())
