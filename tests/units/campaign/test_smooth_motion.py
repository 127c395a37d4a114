"""Motions of records are smoothed and differentiated without taking noise for motion, whatever they are."""

import numpy as np
import pytest

from pipeclamp_identification.signals.half_cycles import half_cycles
from pipeclamp_identification.signals.smooth_motion import smooth_motion

TIME = np.arange(10000) / 500.0


def rms(values):
    return np.sqrt(np.mean(np.asarray(values) ** 2))


def sweep(time, amplitude=5.0, rate=0.2):
    """A sweep from 0.5 Hz on that begins and ends at rest: y, v, a."""
    length = time[-1] - time[0]
    t = time - time[0]
    window, slope, curve = (
        np.sin(np.pi * t / length) ** 2,
        np.pi / length * np.sin(2 * np.pi * t / length),
        2 * (np.pi / length) ** 2 * np.cos(2 * np.pi * t / length),
    )
    phase, omega, turn = 2 * np.pi * (0.5 * t + rate * t**2 / 2), 2 * np.pi * (0.5 + rate * t), 2 * np.pi * rate
    s, c = np.sin(phase), np.cos(phase)
    return (
        amplitude * window * s,
        amplitude * (slope * s + window * omega * c),
        amplitude * (curve * s + 2 * slope * omega * c + window * (turn * c - omega**2 * s)),
    )


def test_a_motion_without_noise_comes_back_with_its_derivatives():
    found = smooth_motion(TIME, sweep(TIME)[0])
    for name, values, share in zip("yva", sweep(TIME), (1e-6, 1e-5, 1e-4), strict=True):
        assert rms(getattr(found, name) - values) < share * rms(values), name
    assert found.noise_mm < 1e-6


@pytest.mark.parametrize("noise", [0.001, 0.02])
def test_noise_is_found_and_left_out_of_the_velocity(noise):
    y, v, _ = sweep(TIME)
    found = smooth_motion(TIME, y + noise * np.random.default_rng(1).standard_normal(len(TIME)))
    assert found.noise_mm == pytest.approx(noise, rel=0.1)
    assert rms(found.y - y) < 0.6 * noise
    raw = np.gradient(y + noise * np.random.default_rng(1).standard_normal(len(TIME)), TIME)
    assert rms(found.v - v) < 0.3 * rms(raw - v)


def test_at_rest_noise_has_no_direction():
    """A record rests, moves, and rests again elsewhere: its quiet parts stand still in most samples."""
    y = np.where(TIME < 8, 0.0, np.where(TIME > 12, 3.0, 1.5 * (1 - np.cos(np.pi * (TIME - 8) / 4))))
    found = smooth_motion(TIME, y + 0.002 * np.random.default_rng(2).standard_normal(len(TIME)))
    quiet = (TIME < 7.5) | (TIME > 12.5)
    assert np.mean(found.v[quiet] == 0.0) > 0.95
    assert np.max(found.v) == pytest.approx(1.5 * np.pi / 4, rel=0.02)


@pytest.mark.parametrize("phase", [0.0, 1.0])
def test_a_record_may_begin_and_end_in_motion(phase):
    y = 2 * np.sin(2 * np.pi * 1.3 * TIME + phase)
    found = smooth_motion(TIME, y)
    v = 2 * np.pi * 1.3 * 2 * np.cos(2 * np.pi * 1.3 * TIME + phase)
    assert rms(found.v - v) < 0.01 * rms(v)
    assert found.frequency == pytest.approx(1.3, rel=0.02)
    assert found.amplitude == pytest.approx(2.0, rel=0.02)


def test_clocks_may_be_rounded_or_uneven():
    rounded = np.round(np.arange(20000) / 1024.0, 5)
    uneven = np.sort(np.concatenate([np.arange(0, 20, 0.004), np.arange(5, 10, 0.001) + 0.0005]))
    for time in (rounded, uneven):
        y, v, _ = sweep(time)
        found = smooth_motion(time, y)
        assert np.ptp(np.diff(found.time)) < 1e-9
        assert rms(np.interp(time, found.time, found.v) - v) < 0.01 * rms(v)


def test_half_cycles_of_a_cosine_are_its_phase():
    phase = 2 * np.pi * TIME / 4
    found = half_cycles(3 * np.cos(phase), np.full(len(TIME), 0.3))
    degrees = np.degrees(phase) % 180
    inside = (degrees > 1) & (degrees < 179)
    assert np.allclose(found.degrees[inside], degrees[inside], atol=0.5)
    assert np.array_equal(found.rising[inside], (np.sin(phase) < 0)[inside])


def test_ripple_on_a_larger_motion_is_no_reversal():
    slow = 3 * np.cos(2 * np.pi * TIME / 4)
    plain = half_cycles(slow, np.full(len(TIME), 0.3))
    rippled = half_cycles(slow + 0.05 * np.sin(2 * np.pi * 20 * TIME), np.full(len(TIME), 0.3))
    apart = np.abs(np.gradient(slow, TIME)) > 1.0
    assert np.array_equal(plain.rising[apart], rippled.rising[apart])


def test_a_motion_that_never_turns_is_one_half_cycle():
    found = half_cycles(TIME**2, np.full(len(TIME), 0.1))
    assert found.rising.all()
    assert (np.diff(found.degrees) >= 0).all()
