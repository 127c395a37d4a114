"""Loops that make energy, or whose force falls with the displacement, are told once, and only beyond scatter."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record

NOISE_N = 20.0


@pytest.fixture
def remarks(campaign_folder, harmonic_record, csv_text):
    """Give a function that gives the remarks on runs whose force has these fundamentals, and noise."""

    def of(*forces, seed=1):
        random, records = np.random.default_rng(seed), {}
        for number, force in enumerate(forces):
            record = harmonic_record(force=(0.0, force))
            noisy = record.force_N + random.normal(0.0, NOISE_N, len(record.force_N))
            records[f"runs/r{number}.csv"] = csv_text(Record(record.time_s, record.displacement_mm, noisy))
        table = "run,file\n" + "".join(f"r{number},runs/r{number}.csv\n" for number in range(len(forces)))
        told = read_campaign(campaign_folder(table=table, records=records)).remarks
        return [words for words in told if "the loops make" in words or "the force falls" in words]

    return of


def test_a_delayed_channel_is_told_once_with_the_worst_run(remarks):
    late = [2000.0 * np.exp(1j * np.arcsin(loss)) for loss in (0.1, -0.1, -0.3, -0.2)]
    (words,) = remarks(*late)
    assert words.startswith(
        "in 3 of 4 runs the loops make energy, most in run 'r2' (loss factor -0.3 of its fundamental, "
    )
    assert words.endswith(" a delay between the channels")


def test_what_scatter_makes_is_not_told(remarks):
    """A spring without loss: half of its loops make a little energy by their noise."""
    assert remarks(*[2000.0] * 40) == []


def test_a_passive_device_has_no_remark(remarks):
    assert remarks(2000.0 + 40.0j, 40.0 + 400.0j) == []


def test_a_force_that_falls_with_the_displacement_is_told(remarks):
    """A wire rope's shaker had been read without a word, and its law had no stiffness."""
    (words,) = remarks(2000.0 + 40.0j, -2000.0 + 400.0j, -800.0 + 400.0j)
    assert words.startswith(
        "in 2 of 3 runs the force falls with the displacement, most in run 'r1' (-2499 N/mm): a mass"
    )


def test_a_damper_without_a_spring_shows_either_sign(remarks):
    assert remarks(*[400.0j] * 40) == []
