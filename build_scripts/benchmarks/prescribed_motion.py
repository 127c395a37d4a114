"""A clamp FMU under a prescribed motion: which A and f its law should be taken for, tried on motions of all kinds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt
from pathlib import Path

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.equations.symbols import REFERENCES, T_0
from pipeclamp_system.fmus.participant import FmuParticipant, opened


@dataclass(frozen=True, eq=False)
class Motion:
    """A displacement over time.

    Attributes:
        time: s, (n,), evenly spaced from 0.
        s: m, (n,).
        v: m/s, (n,).
    """

    time: Array
    s: Array
    v: Array

    @property
    def conditions(self) -> tuple[float, float]:
        """A (mm) and f (Hz) of the whole motion: sqrt(2 var s) and sqrt(var v/var s)/(2 pi)."""
        variance = float(np.var(self.s))
        return 1e3 * sqrt(2 * variance), sqrt(float(np.var(self.v)) / variance) / (2 * pi)


def motions(amplitude: float, frequency: float, cycles: int = 40, steps: int = 200) -> Mapping[str, Motion]:
    """Give a steady sine, a slow sweep, two tones and random motion of the same size.

    Args:
        amplitude: mm, sqrt(2 var) of each motion; the sweep's falls from 1.4 to 0.6 times it.
        frequency: Hz, in the middle of each; the sweep runs over an octave.
        cycles: of the middle frequency.
        steps: samples in a cycle of it.
    """
    h = 1 / (frequency * steps)
    time: Array = h * np.arange(cycles * steps + 1, dtype=np.float64)
    stop = time[-1]
    rate = np.log(2) / stop
    phase = 2 * pi * frequency / sqrt(2) * (np.exp(rate * time) - 1) / rate
    rng = np.random.default_rng(1)
    tones = rng.uniform(0.5, 1.5, 60) * frequency
    phases = rng.uniform(0, 2 * pi, 60)
    shapes = {
        "steady sine": np.sin(2 * pi * frequency * time),
        "slow sweep": (1.4 - 0.8 * time / stop) * np.sin(phase),
        "two tones": (np.sin(2 * pi * 0.7 * frequency * time) + np.sin(2 * pi * 1.45 * frequency * time)) / sqrt(2),
        "random": np.sin(2 * pi * np.outer(time, tones) + phases).sum(axis=1),
    }
    found = {}
    for name, shape in shapes.items():
        scale = 1.0 if name == "slow sweep" else 1 / sqrt(2 * float(np.var(shape)))
        s = 1e-3 * amplitude * scale * shape
        found[name] = Motion(time, s, np.gradient(s, h, edge_order=2))
    return found


def force_on(fmu: Path, motion: Motion, parameters: Mapping[str, float | bool]) -> Array:
    """Give the force into a clamp FMU that is moved along a motion, N, (n,).

    Raises:
        UserError: the FMU can't be loaded, or refuses.
    """
    h = float(motion.time[1])
    with opened([(fmu, "clamp")]) as (clamp,):
        start = {"flange.s": float(motion.s[0]), "flange.v": float(motion.v[0])}
        clamp.initialise({"T": REFERENCES[T_0], **parameters, **start})
        participant = FmuParticipant(clamp, ["flange.s", "flange.v"], ["flange.f"], [])
        forces = [participant.outputs()[0]]
        for t, s, v in zip(motion.time[:-1].tolist(), motion.s[1:].tolist(), motion.v[1:].tolist(), strict=True):
            participant.set_inputs((s, v))
            participant.step(t, h)
            forces.append(participant.outputs()[0])
    return np.array(forces)


def mode_errors(law: Path, memory: Path, motion: Motion, given: tuple[float, float]) -> Mapping[str, float]:
    """Give how far a law is from one with memory, which needs no A, on the same motion, for each source of A and f.

    Args:
        law: FMU of the law that depends on A and f.
        memory: FMU of the law with memory.
        motion: the motion.
        given: A (mm) and f (Hz) for the mode "given".

    Returns:
        rms of the difference of the forces as a share of the rms force, for "given", "solved" and "tracked".
    """
    truth = force_on(memory, motion, {})
    solved = motion.conditions
    settings: Mapping[str, Mapping[str, float | bool]] = {
        "given": {"A": 1e-3 * given[0], "f": given[1]},
        "solved": {"A": 1e-3 * solved[0], "f": solved[1]},
        "tracked": {"A": 1e-3 * solved[0], "f": solved[1], "track": True},
    }
    scale = float(np.sqrt(np.mean(truth**2)))
    return {
        mode: float(np.sqrt(np.mean((force_on(law, motion, parameters) - truth) ** 2))) / scale
        for mode, parameters in settings.items()
    }
