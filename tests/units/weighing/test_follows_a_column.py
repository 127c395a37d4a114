"""A further column: named where it plainly matters, though its curve is off between levels, and not for a mere mean."""

import numpy as np
import pytest
from few_effects import few_effects

from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.diagnosis.verdict import diagnose
from pipeclamp_identification.fitting.heldout import further_groups, kept_at_ends
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Structure

CONDITIONS = [(A, f) for A in (3.0, 8.0, 20.0) for f in (0.5, 1.5)]


@pytest.fixture
def tested(run_of, campaign_of):
    """Give a campaign of a damper whose force in N is damper(y, v, u) at the levels u(place) of a column."""

    def made(column, damper):
        random = np.random.default_rng(4)
        runs = []
        for place, (A, f, u) in enumerate(column):
            time = np.arange(round(5 * 200 / f) + 1) / 200
            y = A * np.sin(2 * np.pi * f * time)
            v = 2 * np.pi * f * A * np.cos(2 * np.pi * f * time)
            force = damper(y, v, u)
            noise = 0.01 * np.std(force) * random.standard_normal(len(time))
            runs.append(run_of(Record(time, y, force + noise), f"r{place}", conditions={"current_A": u}))
        return campaign_of(*runs)

    return made


def test_a_column_that_takes_most_is_a_part_though_its_curve_is_off_between_levels(tested):
    """Of a damper whose force saturates with its current `oil_damper` or `slip_lock` had been named, 20 % of it.

    Without the column the law is right at medium currents, and these alone are left out by their level.
    """

    def saturating(y, v, u):
        return 2 * y + (10 + 1400 * (1 - np.exp(-u / 0.2))) * np.tanh(v / 8)

    campaign = tested([(A, f, u) for A, f in CONDITIONS for u in (0.0, 0.3, 0.8, 1.6)], saturating)
    with few_effects("condition", "viscous"):
        found = diagnose(Structure("power"), campaign)
    column = next(each for each in found.candidates if each.effects == ("condition:current_A",))
    assert column.heldout_by["current_A"] > found.law.heldout_by["current_A"], "the case that this is about"
    assert column.over_range["current_A"] < found.law.over_range["current_A"]
    assert (found.verdict, found.effects, found.kind) == ("missing", ("condition:current_A",), "part")
    assert any("between the levels of current_A that were tested" in reason for reason in found.reasons)


def test_a_column_that_hardly_varies_is_no_rival_of_a_mean_force(tested):
    """Of a damper with gas a mean force was missing, and the room's humidity would have taken as much."""
    humidity = np.random.default_rng(1).uniform(45, 50, 4 * len(CONDITIONS)).round()
    levels = [(A, f, humidity[place]) for place, (A, f) in enumerate(4 * CONDITIONS)]
    campaign = tested(levels, lambda y, v, u: 30 * y + 2.0 * v + 300 + 4 * y**2)
    with few_effects("condition", "offset"):
        found = diagnose(Structure("power"), campaign)
    assert any(each.effects == ("condition:current_A",) for each in found.candidates)
    assert (found.verdict, found.effects) == ("missing", ("offset",))


def test_the_ends_of_a_column_are_kept(tested):
    loops = loops_of(tested([(A, f, u) for A, f in CONDITIONS for u in (0.0, 1.0, 2.0, 3.0)], lambda y, v, u: y + v))
    ends = kept_at_ends(loops)["current_A"]
    assert np.array_equal(ends, np.isin(loops.conditions["current_A"], [0.0, 3.0]))
    assert np.array_equal(ends, further_groups(loops)["current_A"] == -1)
