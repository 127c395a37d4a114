"""What an error along free motions alone calls for: no more than scatter an FMU, more than that sines to diagnose."""

import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.main import get_command

from pipeclamp.cli.app import app
from pipeclamp.show.comparison import how_much
from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.diagnosis.further_test.limits import Limits, limits_words, parse_limits
from pipeclamp_identification.fitting.free_misfit import FreeMisfit
from pipeclamp_identification.workflow.after_comparison import after_comparison
from pipeclamp_identification.workflow.along_free import along_free

TIME = np.arange(8000) / 400.0
FORCE = 900.0 * np.sin(2 * np.pi * 1.3 * TIME) * np.sin(np.pi * TIME / 20.0)
NOISE = np.random.default_rng(5).normal(0.0, 6.0, len(TIME))
SLOW = np.convolve(NOISE, np.ones(40), mode="same") / np.sqrt(40.0)
"""The same noise through a sensor's low-pass filter: neighbouring samples tell next to nothing of it."""
CAMPAIGN = Campaign(Path("quakes"), "quakes", "", (), "", ())


def misfit(off, scatter_on_sines=None, kelvin=293.15):
    A = np.linspace(0.4, 1.17, len(TIME))
    f = np.linspace(1.0, 2.0, len(TIME))
    return FreeMisfit(
        "quake", TIME, FORCE / 1000, FORCE, FORCE + off, FORCE, A, f, ((0.2, 1.0), (1.0, 5.0)), kelvin, None, False,
        scatter_on_sines=scatter_on_sines,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("off", "scatter_on_sines", "explained"),
    [
        (NOISE, None, True),
        (np.zeros(len(TIME)), None, True),
        (NOISE + 0.006 * FORCE, None, True),
        (NOISE + 0.03 * FORCE, None, False),
        (0.03 * FORCE, None, False),
        (SLOW, None, False),
        (SLOW, 0.015, True),
        (SLOW, 0.005, False),
    ],
)
def test_what_scatter_explains(off, scatter_on_sines, explained):
    found = along_free([misfit(off, scatter_on_sines)])
    assert found.scatter_explains is explained
    assert ("nothing is found missing" in found.words()) is explained


@pytest.mark.parametrize(
    ("scatter_on_sines", "told"),
    [
        (None, "judged by the noise between neighbouring samples"),
        (0.05, "scatter alone makes 5.00%, judged by that of the law's own"),
    ],
)
def test_the_first_words_tell_the_scatter_that_the_last_ones_judge_by(scatter_on_sines, told):
    held = Comparison(None, None, None, (), {}, (misfit(NOISE + 0.03 * FORCE, scatter_on_sines),))
    (first,) = how_much(held)
    found = along_free(held.free)
    assert first.startswith("RMS error 3.")
    assert f"scatter alone makes {found.scatter:.2%}" in first
    assert told in first
    assert "known" not in first
    assert "beyond scatter" in found.words()


def test_the_noise_is_that_of_the_samples_whatever_the_law_lacks():
    for lack in (0.0, 0.1):
        share = np.std(NOISE) / np.std((1.0 + lack) * FORCE)
        assert along_free([misfit(NOISE + lack * FORCE)]).scatter == pytest.approx(share, rel=0.1)


@pytest.mark.parametrize(
    ("off", "kelvin", "line"),
    [
        (NOISE, 293.15, "pipeclamp build-fmu law.json -o law.fmu --track"),
        (
            0.1 * FORCE,
            293.15,
            "pipeclamp plan -o planned --law law.json --limits A=..0.9,f=1.05..1.95,T=20..20",
        ),
        (0.1 * FORCE, float("nan"), "pipeclamp plan -o planned --law law.json --limits A=..0.9,f=1.05..1.95"),
    ],
)
def test_the_next_command_follows_from_what_was_found(off, kelvin, line):
    held = Comparison(None, CAMPAIGN, None, (), {}, (misfit(off, kelvin=kelvin),))
    assert after_comparison("law.json", "quakes", held) == line
    name, *words = shlex.split(line)[1:]
    get_command(app).commands[name].make_context(name, words, resilient_parsing=True)


def test_no_frequency_is_asked_for_where_no_time_was_measured():
    untimed = replace(CAMPAIGN, time_measured=False)
    held = Comparison(None, untimed, None, (), {}, (misfit(0.1 * FORCE),))
    assert after_comparison("law.json", "wall", held).endswith("--limits A=..0.9,T=20..20")


def test_corner_points_of_loops_show_no_scatter():
    turning = np.arange(len(TIME)) % 2
    corners = replace(misfit(0.1 * FORCE), y=2.0 * turning - 1.0, measured=900.0 * turning)
    found = along_free([corners])
    assert found.scatter is None
    assert "too far apart to show noise" in found.scatter_words()
    assert along_free([replace(corners, scatter_on_sines=0.02)]).scatter == 0.02


def test_the_corners_of_a_law_that_errs_are_no_noise():
    law = misfit(0.0).computed + 500.0 * np.sign(np.sin(900.0 * TIME))
    assert along_free([replace(misfit(NOISE), computed=law)]).scatter == pytest.approx(
        np.std(NOISE) / np.std(FORCE), rel=0.1
    )


@pytest.mark.parametrize("text", ["A=..1.2", "f=0.5..,T=-20..60", "A=0.1..2,f=0.5..20,T=20..300,v=..300,F=..500"])
def test_limits_are_written_as_they_are_read(text):
    assert limits_words(parse_limits(text)) == text
    assert not limits_words(Limits())
