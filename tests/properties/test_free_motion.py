"""A law along free motions: held against integrations of its equations by other code, and against its own sines."""

from dataclasses import replace

import numpy as np
import pytest

from pipeclamp_identification.campaign.free_motion import FreeRun, free_motion
from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.runs_table import Setup
from pipeclamp_identification.comparison.answer import comparison_answer
from pipeclamp_identification.comparison.compare import compare
from pipeclamp_identification.fitting.free_misfit import free_misfits
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import HistoryStep, law_of, read_law

FINE = 20
"""Steps of the independent integration between two samples."""
VALUES = {"k10": 900.0, "k30": 40.0, "c0": 150.0, "alpha0": 0.4, "k_s": 700.0, "z_s": 500.0}
OFFSET, DELAY = 55.0, 0.004


def sweep(time):
    """From 0.4 to 4 Hz in 20 s, swelling and fading."""
    return 2.0 * np.sin(np.pi * time / 20) ** 2 * np.sin(2 * np.pi * (0.4 * time + 0.09 * time**2))


def random(time):
    """Many sines of random phases under a window that begins and ends at rest."""
    draw = np.random.default_rng(5)
    lines = ((f, draw.uniform(0, 2 * np.pi), draw.normal() / f) for f in np.arange(0.3, 5.0, 0.17))
    return (
        np.sin(np.pi * time / 20) * sum(a * np.sin(2 * np.pi * f * time + phase) for f, phase, a in lines) * time / 20
    )


def integrated(motion, rate, v_r):
    """Give a record of spring, power damping and one elastic-slip element, its force late and off zero."""
    time = np.arange(round(20 * rate * FINE)) / (rate * FINE)
    y = motion(time)
    v = np.gradient(y, time)
    slip = np.zeros(len(y))
    for n in range(1, len(y)):
        slip[n] = max(-VALUES["z_s"], min(VALUES["z_s"], slip[n - 1] + VALUES["k_s"] * (y[n] - y[n - 1])))
    damping = VALUES["c0"] * v * (v**2 + v_r**2) ** ((VALUES["alpha0"] - 1) / 2)
    force = VALUES["k10"] * y + VALUES["k30"] * y**3 + damping + slip
    late = np.interp(time - DELAY, time, force) + OFFSET
    return Record(time[::FINE], y[::FINE], late[::FINE])


def free_run(record, name="run", **conditions):
    return FreeRun(name, Setup(**conditions), record, free_motion(record))


@pytest.fixture(scope="module")
def law(write_law, tmp_path_factory):
    path = tmp_path_factory.mktemp("law") / "law.json"
    values = VALUES | {"F_o": OFFSET, "tau_d": DELAY}
    write_law(path, values, effects=("memory", "offset", "delay"), v_r=0.5)
    return read_law(path)


@pytest.mark.parametrize("motion", [sweep, random])
@pytest.mark.parametrize("rate", [200, 1000])
def test_the_laws_own_force_integrated_by_other_code_leaves_nearly_nothing(law, motion, rate):
    (found,) = free_misfits(law, [free_run(integrated(motion, rate, law.smoothing["v_r"]))])
    assert found.nrmse < {200: 0.004, 1000: 0.001}[rate]
    assert not found.adrift
    assert found.came_from is None


def test_noise_of_the_sensors_is_what_is_left(law):
    clean, draw = integrated(random, 500, law.smoothing["v_r"]), np.random.default_rng(6)
    noisy = Record(
        clean.time_s,
        clean.displacement_mm + 0.0005 * draw.standard_normal(len(clean.time_s)),
        clean.force_N + 10 * draw.standard_normal(len(clean.time_s)),
    )
    (found,) = free_misfits(law, [free_run(noisy)])
    noise = 10 / np.sqrt(np.mean(noisy.force_N**2))
    assert noise < found.nrmse < 1.2 * noise


@pytest.mark.parametrize(
    ("where", "words"),
    [
        (lambda t, y, v: (v > 0) & (t > 10), ("while the displacement rises", "in the second half of the record")),
        (lambda t, y, v: y < -0.2, ("at negative displacement",)),
        (lambda t, y, v: np.abs(v) > np.max(np.abs(v)) / 3, ("at a speed from",)),
    ],
)
def test_the_error_is_found_where_it_is(law, where, words):
    clean = integrated(random, 200, law.smoothing["v_r"])
    time, y = clean.time_s, clean.displacement_mm
    off = 300.0 * where(time, y, np.gradient(y, time))
    campaign = Campaign("t", "", "sha256:0", (), (), (), free=(free_run(replace(clean, force_N=clean.force_N + off)),))
    held = compare(law, campaign)
    answer = comparison_answer(held)
    region = answer.where.free.region
    assert all(any(found.startswith(word) for found in region.words) for word in words), region.words
    assert region.share > 0.85
    assert answer.nrmse == pytest.approx(np.sqrt(np.sum(off**2) / np.sum(held.free[0].measured ** 2)), rel=0.05)
    assert answer.noise_nrmse is None
    free = answer.where.free
    for parts in (free.components, free.time, free.places, free.directions, free.speed, free.tracked_amplitude):
        assert sum(part.share for part in parts) == pytest.approx(1.0)
        assert sum(part.even_share for part in parts) == pytest.approx(1.0)


@pytest.mark.parametrize("past", [-3.0, -0.4, 0.5, 3.0])
def test_what_a_specimen_went_through_before_shows_in_its_force_at_rest(law, past):
    """It came to rest from elsewhere, on either side; part of its friction still holds it when the record begins."""

    def with_past(time):
        return np.where(time < 2, past * (1 + np.cos(np.pi * np.clip(time, 0, 2) / 2)) / 2, 0) + np.where(
            time > 4, random(np.clip(time - 4, 0, None) * 20 / 16), 0
        )

    whole = integrated(with_past, 500, law.smoothing["v_r"])
    later = slice(1300, None)
    record = Record(whole.time_s[later], whole.displacement_mm[later], whole.force_N[later])
    held = compare(law, Campaign("t", "", "sha256:0", (), (), (), free=(free_run(record),)))
    (found,) = held.free
    assert found.nrmse < 0.002
    assert np.sign(found.came_from) == np.sign(past)
    assert comparison_answer(held).runs[0].came_from_mm == found.came_from
    unloaded = replace(record, force_N=record.force_N - np.mean(record.force_N[:100]) + OFFSET)
    assert free_misfits(law, [free_run(unloaded)])[0].came_from is None


def test_the_scale_of_force_does_not_matter(law):
    clean = integrated(sweep, 200, law.smoothing["v_r"])
    thousand = {"k10", "k30", "c0", "k_s", "z_s", "F_o"}
    scaled_law = law.model_copy(
        update={
            "coefficients": {
                name: entry.model_copy(update={"value": entry.value * 1000}) if name in thousand else entry
                for name, entry in law.coefficients.items()
            }
        }
    )
    off = replace(clean, force_N=1.2 * clean.force_N)
    (plain,) = free_misfits(law, [free_run(off)])
    (scaled,) = free_misfits(scaled_law, [free_run(replace(off, force_N=1000 * off.force_N))])
    assert scaled.nrmse == pytest.approx(plain.nrmse, rel=1e-9)
    assert scaled.adrift == plain.adrift


def test_an_element_that_never_slips_takes_the_measured_mean(write_law, tmp_path):
    """Along motions of 1 mm an element of 5 kN and 700 N/mm keeps whatever it was loaded with before."""
    path = tmp_path / "law.json"
    write_law(path, VALUES | {"z_s": 5000.0}, effects=("memory",), v_r=0.5)
    time = np.arange(4000) / 200
    y = sweep(time)
    v = np.gradient(y, time)
    force = 1600.0 * y + 40 * y**3 + 150 * v * (v**2 + 0.25) ** (-0.3) + 800.0
    (found,) = free_misfits(read_law(path), [free_run(Record(time, y, force))])
    assert found.adrift
    assert found.nrmse < 0.01


@pytest.fixture(scope="module")
def sines():
    """A law that errs, and long runs of sines declared free as well."""
    truth = open_law("emwm2")
    wrong = truth.model_copy(
        update={
            "coefficients": truth.coefficients
            | {"c0": truth.coefficients["c0"].model_copy(update={"value": 1.3 * truth.coefficients["c0"].value})}
        }
    )
    plan = Plan(amplitudes=(0.3, 0.9), frequencies=(1.5, 4.0), temperatures=(20.0, 200.0), cycles=25.0, rate=500.0)
    return wrong, list(virtual_runs(law_of(truth), plan, {}))


def test_a_sine_declared_free_errs_as_a_sine_once_its_beginning_has_passed(sines, run_of):
    law, written = sines
    runs = [
        run_of(one.record, f"r{index}", temperature_C=one.row["temperature_C"]) for index, one in enumerate(written)
    ]
    as_sines = compare(law, Campaign("t", "", "sha256:0", tuple(runs), (), ()))
    free = free_misfits(law, [free_run(one.record, temperature_C=one.row["temperature_C"]) for one in written])
    for run, sine, other in zip(runs, as_sines.runs, free, strict=True):
        late = slice(int(run.cycles.bounds[-13]), int(run.cycles.bounds[-1]))
        error = np.sqrt(np.sum((other.measured - other.computed)[late] ** 2) / np.sum(other.measured[late] ** 2))
        assert error == pytest.approx(sine.nrmse, rel=0.05)
        assert other.amplitude[late] == pytest.approx(as_sines.loops.amplitude_mm[runs.index(run)], rel=0.02)
        assert other.frequency[late] == pytest.approx(run.cycles.frequency_Hz, rel=0.02)


def test_temperatures_known_for_some_runs_only_are_refused(sines):
    law, written = sines
    runs = [free_run(written[0].record, "a", temperature_C=20.0), free_run(written[1].record, "b")]
    with pytest.raises(UserError, match=r"known for 1 of 2 runs only, not for b"):
        free_misfits(law, runs)
    with pytest.raises(UserError, match=r"known for 1 of 2 runs only, not for b"):
        free_misfits(law, runs[1:], {"a": 293.15})
    assert np.isnan(free_misfits(law, runs[1:])[0].temperature_K)


def test_a_temperature_that_is_measured_along_the_record_counts(sines):
    law, written = sines
    record = written[0].record
    T = np.linspace(20.0, 200.0, len(record.time_s))
    (warm,) = free_misfits(law, [free_run(replace(record, temperature_C=T), temperature_C=500.0)])
    (cold,) = free_misfits(law, [free_run(record, temperature_C=20.0)])
    (hot,) = free_misfits(law, [free_run(record, temperature_C=200.0)])
    assert warm.temperature_K == pytest.approx(110 + 273.15)
    assert np.allclose(warm.computed[:50], cold.computed[:50], rtol=0.02)
    assert np.allclose(warm.computed[-50:], hot.computed[-50:], rtol=0.02, atol=2)


def test_a_condition_that_the_law_follows_must_be_known(write_law, tmp_path):
    path = tmp_path / "law.json"
    write_law(path, VALUES, effects=("density",), v_r=0.5)
    with pytest.raises(UserError, match="density_g_cm3, which isn't known for run"):
        free_misfits(read_law(path), [free_run(integrated(sweep, 200, 0.5))])


def test_what_a_constant_force_costs_along_a_motion_is_told(law):
    """Sines in which a clamp always slips had given the law a mean force that isn't there at rest."""
    clean = integrated(random, 200, law.smoothing["v_r"])
    centred = replace(clean, force_N=clean.force_N - OFFSET)
    wrong = law.model_copy(
        update={
            "coefficients": law.coefficients
            | {"F_o": law.coefficients["F_o"].model_copy(update={"value": float(np.std(clean.force_N))})}
        }
    )
    answer = comparison_answer(compare(wrong, Campaign("t", "", "sha256:0", (), (), (), free=(free_run(centred),))))
    (run,) = answer.runs
    assert run.rest_force_N == pytest.approx(np.std(clean.force_N), rel=0.01)
    assert run.nrmse > 0.8
    assert run.nrmse_without_rest_force < 0.02
    assert any("has a constant force" in words for words in answer.where.words)
    right = comparison_answer(compare(law, Campaign("t", "", "sha256:0", (), (), (), free=(free_run(clean),))))
    assert not any("has a constant force" in words for words in right.where.words)


def test_the_share_of_the_error_outside_of_the_laws_range_is_told(law):
    """All of the error is put where the motion is small."""
    law = law.model_copy(
        update={"range": {**law.range, "A": law.range["A"].model_copy(update={"minimum": 1.0, "maximum": 2.0})}}
    )
    clean = integrated(random, 200, law.smoothing["v_r"])
    campaign = Campaign("t", "", "sha256:0", (), (), (), free=(free_run(clean),))
    (followed,) = compare(law, campaign).free
    low, high = followed.ranges[0]
    outside = (followed.amplitude < low) | (followed.amplitude > high)
    late = outside & (followed.time > 4)
    assert 0.1 < np.mean(late) < 0.9
    off = replace(clean, force_N=clean.force_N + 300.0 * late)
    (found,) = comparison_answer(compare(law, Campaign("t", "", "sha256:0", (), (), (), free=(free_run(off),)))).runs
    assert found.tracked_amplitude_mm.outside_share == pytest.approx(np.mean(outside))
    assert found.tracked_amplitude_mm.outside_error_share > 0.95


def told_errors(file, on_left_out):
    """Give a law whose file tells this error on left-out sines."""
    return file.model_copy(update={"history": (HistoryStep(step="t", nrmse=0.0, refitted_nrmse=on_left_out),)})


def test_a_law_without_memory_is_told_what_it_lacks_along_a_free_motion(law, write_law, tmp_path):
    path = tmp_path / "plain.json"
    write_law(path, {name: VALUES[name] for name in ("k10", "k30", "c0", "alpha0")}, v_r=0.5)
    run = free_run(integrated(random, 200, 0.5))
    plain = read_law(path)
    for one, says in (
        (told_errors(plain, 0.01), True),
        (told_errors(plain, 0.9), False),
        (told_errors(law, 0.0), False),
    ):
        answer = comparison_answer(compare(one, Campaign("t", "", "sha256:0", (), (), (), free=(run,))))
        assert any("It has no memory" in words for words in answer.where.words) is says
