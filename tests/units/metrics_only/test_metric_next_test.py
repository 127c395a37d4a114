"""The test that is proposed where only metrics are kept, in words."""

import pytest

from pipeclamp_identification.metrics_only.next_test import MetricProposal


@pytest.mark.parametrize(("timed", "where"), [(True, "0.5 mm, 2 Hz, 20 °C"), (False, "0.5 mm, 20 °C")])
def test_no_frequency_is_stated_where_time_was_not_measured(timed, where):
    proposal = MetricProposal(0.5, 2.0, 20.0, 4.2, ("memory", "coulomb"), timed)
    assert proposal.words() == (
        f"run a sine test at {where}: dW and W of memory and coulomb then differ by 4.2 standard deviations"
    )
