"""How tables show a parameter: what ran into a bound as that bound, on terminals, pages and beside other laws alike."""

import pytest

from pipeclamp.show.law import coefficient_table, parameters_table
from pipeclamp_models.law.bundled import open_law

LAW = open_law("emwm2")


def with_entry(name, **changes):
    entry = LAW.coefficients[name].model_copy(update=changes)
    return LAW.model_copy(update={"coefficients": {**LAW.coefficients, name: entry}})


@pytest.mark.parametrize(
    ("name", "value", "state", "expected"),
    [
        ("alpha0", 1.1e-57, "at_bound", "0 (at its bound)"),
        ("alpha0", 2.4999999, "at_bound", "2.5 (at its bound)"),
        ("alpha0", 1.1e-57, "fitted", 1.1e-57),
        ("c_A", 3.0, "at_bound", "3 (at its bound)"),
    ],
)
def test_a_parameter_at_its_bound_is_shown_as_the_bound(name, value, state, expected):
    file = with_entry(name, value=value, state=state, standard_error=None)
    (shown,) = (row[1] for row in coefficient_table(file).rows if row[0] == name)
    assert shown == expected
    (beside,) = (row[2] for row in parameters_table([file]).rows if row[0] == name)
    assert beside == (expected if isinstance(expected, str) else f"{expected:.4g}")
