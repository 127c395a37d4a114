"""Whatever the error, every breakdown's parts add up to the whole, and their mean square is the nrmse."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeclamp_identification.comparison import breakdown
from pipeclamp_identification.comparison.conditions import conditions_of
from pipeclamp_identification.comparison.sums import error_sums
from pipeclamp_identification.fitting.misfit import overall_noise, overall_nrmse
from pipeclamp_identification.loops.loops import loops_of

RUN = st.fixed_dictionaries(
    {
        "per_cycle": st.floats(40, 400),
        "cycles": st.floats(1.0, 9.0),
        "phase": st.floats(0, 6.28),
        "amplitude": st.sampled_from([0.2, 0.5, 1.0]),
        "T": st.sampled_from([20.0, 100.0, None]),
        "specimen": st.sampled_from(["S1", "S2", None]),
        "harmonic": st.integers(0, 30),
        "size": st.floats(0.1, 500),
        "noise": st.floats(0, 20),
    }
)


@settings(max_examples=25, deadline=None)
@given(cases=st.lists(RUN, min_size=1, max_size=4), seed=st.integers(0, 999))
def test_the_parts_add_up_to_the_whole(harmonic_record, run_of, campaign_of, misfit_of, cases, seed):
    rng = np.random.default_rng(seed)
    runs, misfits = [], []
    for number, case in enumerate(cases):
        record = harmonic_record(
            (0.0, case["amplitude"]), rate=3.0 * case["per_cycle"], cycles=case["cycles"], phase=case["phase"]
        )
        record.force_N[:] += case["noise"] * rng.standard_normal(len(record.force_N))
        run = run_of(record, f"run{number}", temperature_C=case["T"], specimen=case["specimen"])
        runs.append(run)

        def error(phase, cycle, case=case):
            wave = case["size"] * np.cos(case["harmonic"] * phase)
            return wave + case["noise"] * rng.standard_normal(len(phase))

        misfits.append(misfit_of(run, error, case["noise"]))
    campaign, misfits = campaign_of(*runs), tuple(misfits)
    loops = loops_of(campaign)
    sums = error_sums(campaign, loops, misfits)
    whole, nrmse = sum(misfit.squared_error for misfit in misfits), overall_nrmse(misfits)
    over_samples = [breakdown.along_loop(sums), breakdown.by_place(sums), breakdown.by_branch(sums)]
    over_samples += [breakdown.along_cycles(sums)]
    over_samples += [breakdown.by_condition(sums, one) for one in conditions_of(campaign, loops)]
    for parts in over_samples:
        force = sum(part.squared_force for part in parts.parts)
        assert force == pytest.approx(sum(misfit.squared_force for misfit in misfits))
        mean = sum((part.nrmse or 0.0) ** 2 * part.squared_force for part in parts.parts) / force
        assert math.sqrt(mean) == pytest.approx(nrmse)
    for parts in (*over_samples, breakdown.by_harmonic(sums)):
        assert parts.squared_error == pytest.approx(whole)
        assert sum(map(parts.share, parts.parts)) == pytest.approx(1.0)
        assert all(parts.share(part) >= -1e-9 for part in parts.parts)
    harmonics = breakdown.by_harmonic(sums).parts
    assert math.sqrt(sum(part.nrmse**2 for part in harmonics)) == pytest.approx(nrmse)
    if all(run.scatter_known for run in sums):
        for parts in over_samples:
            scatter = sum(part.squared_scatter for part in parts.parts)
            force = sum(part.squared_force for part in parts.parts)
            assert math.sqrt(scatter / force) == pytest.approx(overall_noise(misfits), abs=1e-12)
