"""A law's loop in the middle of its tests, where they determine it better than its parameters one by one."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from pipeclamp.show.law import doubts
from pipeclamp_identification.comparison.in_the_middle import loop_in_the_middle
from pipeclamp_models.base.digits import with_error
from pipeclamp_models.law.file import Covariance, Interval, LawFile
from pipeclamp_models.law.range import intervals_of

PER_CENT_IN_THE_MIDDLE = 1.0


@pytest.fixture
def far_from_1_mm(tmp_path, write_law):
    """Give a law tested from 20 to 45 mm: stiffness known to 1 % at 30 mm, and to some 90 % at 1 mm."""
    path = tmp_path / "law.json"
    write_law(path, {"k10": 100.0, "k1_A": -0.5, "c0": 3.0, "alpha0": 1.0})
    law = LawFile.model_validate(json.loads(path.read_text(encoding="utf-8")))
    middle, exponent = math.log(30.0), 0.25
    share = (PER_CENT_IN_THE_MIDDLE / 100) ** 2 + (middle * exponent) ** 2
    matrix = ((100.0**2 * share, -100.0 * middle * exponent**2), (-100.0 * middle * exponent**2, exponent**2))
    ranges = {"A": (20.0, 45.0, "mm"), "f": (0.5, 2.0, "Hz"), "T": (293.15, 313.15, "K")}
    return law.model_copy(
        update={
            "range": {name: Interval(minimum=a, maximum=b, unit=unit) for name, (a, b, unit) in ranges.items()},
            "covariance": Covariance(names=("k10", "k1_A"), matrix=matrix),
        }
    )


def as_read(law: LawFile) -> LawFile:
    return LawFile.model_validate(law.model_dump(by_alias=True))


def test_what_parameters_leave_open_together_is_known_where_the_tests_are(far_from_1_mm):
    loop = loop_in_the_middle(as_read(far_from_1_mm))
    assert loop.conditions == pytest.approx({"A": 30.0, "f": 1.0, "T": 303.15})
    elastic, viscous = 100 / math.sqrt(30), 3 * 2 * math.pi
    assert loop.stiffness == pytest.approx(math.hypot(elastic, viscous), rel=1e-3)
    # a force amplitude's share is that of its elastic part
    share = elastic**2 / (elastic**2 + viscous**2) * PER_CENT_IN_THE_MIDDLE / 100
    assert loop.stiffness_error == pytest.approx(loop.stiffness * share, rel=0.01)
    assert loop.energy_error == pytest.approx(0.0, abs=1e-6 * loop.dissipated_energy)
    assert loop.dissipated_energy == pytest.approx(math.pi * 30 * 3 * 2 * math.pi * 30 / 1e3, rel=1e-3)


def test_it_is_told_with_the_law(far_from_1_mm):
    first, second = doubts(as_read(far_from_1_mm))
    assert first.startswith("In the middle of its tests (A 30 mm, f 1 Hz, T 30 °C): 26.2 ")
    assert second.endswith("outside of these tests, and may be less sure.")
    around = {**far_from_1_mm.range, "A": Interval(minimum=0.5, maximum=45.0, unit="mm")}
    assert len(doubts(as_read(far_from_1_mm.model_copy(update={"range": around})))) == 1


def test_tests_at_20_degrees_have_their_middle_there(far_from_1_mm):
    """The range's ends are whole kelvins, 293 and 294: 20.4 degC had been told of a clamp that was never so warm."""
    at_20 = {**far_from_1_mm.range, **intervals_of({"T": np.array([293.15, 293.15])})}
    law = as_read(far_from_1_mm.model_copy(update={"range": at_20}))
    assert loop_in_the_middle(law).conditions["T"] == pytest.approx(293.15)
    assert "T 20 °C" in doubts(law)[0]


def test_nothing_is_told_of_a_law_whose_errors_are_unknown(far_from_1_mm):
    assert loop_in_the_middle(as_read(far_from_1_mm.model_copy(update={"covariance": None}))) is None


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [(83.1234, 0.52, "83.1 ± 0.5"), (15.8, 5.2, "16 ± 5"), (0.0123, 0.5, "0.01 ± 0.5"), (5.0, 0.0, "5 ± 0")],
)
def test_a_value_ends_where_its_error_begins(value, error, shown):
    assert with_error(value, error) == shown


def test_no_error_is_too_large_to_be_written():
    assert with_error(1.0, float(np.finfo(float).max)).startswith("1 ± ")
