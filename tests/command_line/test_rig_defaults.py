"""What `rig` does unasked: the same from a terminal, from Python and by the rig's own plan."""

import inspect
from dataclasses import fields

import pytest

from pipeclamp.api.virtual import OF_RUNS, SETTINGS
from pipeclamp.cli.campaigns import rig
from pipeclamp.cli.terminal import numbers_in
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan

OPTIONS = inspect.signature(rig).parameters
DEFAULTS = {one.name: one.default for one in fields(Plan)}


@pytest.mark.parametrize("name", [*SETTINGS, "amplitudes", "frequencies", "temperatures"])
def test_an_option_that_is_left_out_is_what_the_plan_has(name):
    default = OPTIONS[name].default
    assert (numbers_in(default, name) if isinstance(default, str) else default) == DEFAULTS[name]


def test_every_setting_of_the_plan_is_an_option():
    assert set(DEFAULTS) - set(OPTIONS) == {"runs"}  # which a plan's folder states
    assert set(DEFAULTS) - set(SETTINGS) == set(OF_RUNS)
