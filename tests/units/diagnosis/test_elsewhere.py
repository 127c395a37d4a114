"""What passes for form on left-out conditions, between levels and beyond harmonics doesn't where it comes together."""

import pytest

from pipeclamp_identification.diagnosis.beyond_harmonics import BeyondHarmonics
from pipeclamp_identification.diagnosis.elsewhere import Elsewhere
from pipeclamp_identification.diagnosis.foretold import ErrorBeyondScatter
from pipeclamp_identification.diagnosis.weighing.between_levels import LeftOutLevel
from pipeclamp_identification.diagnosis.weighing.tolerance import Tolerance


def erring(left_out, between, beyond):
    """Give a law's errors elsewhere, as shares of the force noise; between levels none where no level lies there."""
    worst = None if between is None else LeftOutLevel("A", "0.5 mm", 3 * between, between)
    return Elsewhere(left_out, worst, BeyondHarmonics(3 * beyond, beyond, beyond, ()))


@pytest.mark.parametrize(
    "errors", [(0.0, None, 0.0), (0.7, 0.0, 0.2), (0.4, 0.4, 0.4), (0.0, 0.74, 0.0), (0.7, None, 0.2)]
)
def test_a_small_error_elsewhere_passes_for_form(errors):
    assert not erring(*errors).contradiction


@pytest.mark.parametrize(
    ("errors", "said"),
    [
        ((0.45, 0.66, 0.31), "on left-out conditions, by 0.66 more at A = 0.5 mm when fitted to the other levels, and"),
        ((0.6, None, 0.6), "errs by 0.6 on left-out conditions, and by 0.6 beyond harmonic 20: 0.85 together"),
        ((0.0, 0.8, 0.0), "the law fits the tests at A = 0.5 mm, but fitted to the others alone"),
        ((0.0, 0.0, 0.8), "beyond harmonic 20 the law errs by 2.4 N that repeat with each cycle"),
    ],
)  # fmt: skip
def test_each_alone_or_all_together_contradict_a_law(errors, said):
    assert said in erring(*errors).contradiction


@pytest.mark.parametrize(("proved", "counted"), [(True, 0.2), (False, 0.6)])
def test_doubt_counts_only_against_a_law_with_parts(proved, counted):
    assert Tolerance(0.1, 0.75, 0.75, proved).counted(ErrorBeyondScatter(1.8, 0.6, 0.2)) == counted
