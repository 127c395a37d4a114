"""A description with several problems names the place of each, so that it is mended at once."""

import pytest

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.toml_file import validated
from pipeclamp_models.pipe.description import PipeDescription

PIPE = {
    "name": "pipe",
    "pipe": {"outer_diameter_mm": 114.3, "wall_mm": 3.6, "length_m": 10.0, "material": "carbon steel"},
    "ends": {"left": "pinned", "right": "pinned"},
    "damping": {"ratio": 0.01},
    "modes": {"up_to_Hz": 100.0},
    "excitation": {"kind": "base"},
}


@pytest.mark.parametrize(
    ("without", "told"),
    [
        (("damping",), "damping: is missing; expected it there"),
        (("damping", "modes"), "damping: is missing; expected it there (also to mend: modes)"),
    ],
)
def test_each_missing_table_is_named(without, told):
    with pytest.raises(UserError) as refused:
        validated({name: one for name, one in PIPE.items() if name not in without}, PipeDescription, "pipe.toml")
    assert str(refused.value) == f"pipe.toml: {told}"


def test_a_place_that_may_hold_several_kinds_is_named_once():
    """Each kind has its own problem with what stands there."""
    with pytest.raises(UserError) as refused:
        validated({**PIPE, "ends": {"left": {"stiffness": 1.0}, "right": "pinned"}}, PipeDescription, "pipe.toml")
    assert "also to mend" not in str(refused.value) or "ends.left" not in str(refused.value).split("also to mend")[1]
