"""What a person reads of a co-simulation: amplitudes, where they settle, the energy, and what each law is taken for."""

from __future__ import annotations

from math import sqrt

import numpy as np

from pipeclamp_fmu.slaves.own_motion import LIMIT
from pipeclamp_models.base.digits import plain
from pipeclamp_system.cosim.beating import FEWEST_CYCLES_THAT_SWING, is_judged
from pipeclamp_system.cosim.energy import NAMES
from pipeclamp_system.cosim.repetition import LAST_SHARE
from pipeclamp_system.cosim.result import SETTLED_SHARE, UNEVEN_SHARE, CosimResult
from pipeclamp_system.description.system import ClampSource

NOTABLE_FORM = 0.01
"""Share by which half of peak to peak may differ from sqrt(2) times the rms, as of a motion that is no sine."""

MISMATCH = 0.2
"""Share by which the amplitude of the motion may differ from the one that the law is taken for, before it is said."""


def summary_of(result: CosimResult) -> str:
    """Give amplitudes and the energy balance, for a person to read."""
    trials = result.columns["trials"][1:]
    parts = (f"{NAMES[name]} {plain(value, 4)}" for name, value in result.energy.final().items())
    lines = [
        f"system {result.name!r}: {result.time.size - 1} {result.scheme} steps of {_step_text(result)}, "
        f"{trials.mean():.1f} trials a step (at most {trials.max():.0f})",
        *result.marks(),
        *_about_amplitudes(result),
        *_about_settling(result),
        *_about_repetition(result),
        *_about_short_run(result),
        *_about_small_error(result),
        f"energy, J: {', '.join(parts)}",
        *(line for clamp in result.system.clamps for line in _about_other_motion(result, clamp)),
        *(_about_conditions(result, clamp) for clamp in result.system.clamps),
        *(f"{name}: its law was used beyond the range of its data" for name in result.out_of_range),
        *(f"warning: {warning}" for warning in result.warnings),
    ]
    return "\n".join(lines)


def _about_amplitudes(result: CosimResult) -> list[str]:
    """Say how far clamps and probes move, and with which force."""
    late = "over the last fifth of the run"
    moved = {
        name: f"{1e3 * result.amplitude(f'{name}.s'):.4g} mm" for name in (*result.clamp_names, *result.probe_names)
    }
    return [
        *(
            f"{name}: amplitude {moved[name]}, force {plain(result.amplitude(f'{name}.f'), 4)} N {late}"
            for name in result.clamp_names
        ),
        *(f"{name}: amplitude {moved[name]} {late}" for name in result.probe_names),
    ]


def _about_settling(result: CosimResult) -> list[str]:
    """Say where an amplitude still changes; nothing of one that swings, of which more is said."""
    if result.beats is not None:
        return []
    return [
        f"not settled: the amplitude at {name} changes by {change:.1%} from the last fifth but one to the last, "
        f"expected at most {SETTLED_SHARE:.0%}; use a larger stop_s"
        for name, change in result.unsettled.items()
    ]


def _about_small_error(result: CosimResult) -> list[str]:
    """Say by how much the motion errs for its steps, where that is little, or why it isn't known."""
    lines = []
    if result.beats is not None:
        lines.append("the displacement's error for its steps isn't told: two runs of a swing drift apart")
    if result.step_error is not None and result.step_error <= result.trusted_share:
        lines.append(
            f"the displacement errs by {result.step_error:.2%} in amplitude and phase by its time steps: a second "
            "run in other steps tells it"
        )
    return lines


def _about_other_motion(result: CosimResult, clamp: ClampSource) -> list[str]:
    """Say where a law is taken for another A and f than those of the motion, and what helps."""
    name = clamp.at
    found, assumed = result.amplitude(f"{name}.s"), result.columns[f"{name}.A_used"][-1]
    off = result.columns[f"{name}.forceDeviation"][-1]
    by = f"its force is off by {off:.1%}"
    # Of a law that follows neither A nor f the force is never off: which it is told is no matter.
    matters = clamp.law is None or clamp.mode != "given" or off > 0
    if matters and abs(found - assumed) > MISMATCH * assumed:
        so = f", so that {by}" if off > LIMIT else ""
        return [
            f"{name}: its law is taken for an amplitude of {1e3 * assumed:.4g} mm, and it moves with "
            f"{1e3 * found:.4g} mm{so}: {_about_mismatch(result, clamp)}"
        ]
    return [f"{name}: {by} for the A and f of its motion: {_about_mismatch(result, clamp)}"] if off > LIMIT else []


def _about_mismatch(result: CosimResult, clamp: ClampSource) -> str:
    """Say what helps where a law is taken for another amplitude than that of the motion."""
    if clamp.mode == "given":
        return "set amplitude_mm to that, or solve = true, or track = true"
    if clamp.mode == "solved" and result.unsolved:
        return "A and f are not solved"
    if clamp.mode == "solved" or clamp.at in result.out_of_range:
        return "the range of its data ends there"
    if result.beats is not None:
        return "its amplitude swings"
    return "its motion is no steady sine, or is still changing"


def _about_repetition(result: CosimResult) -> list[str]:
    """Say where the amplitude is settled and yet the motion doesn't repeat itself."""
    if result.unsettled or result.beats is not None or not (unrepeated := result.unrepeated):
        return []
    name, share = max(unrepeated.items(), key=lambda found: found[1])
    return [
        f"the motion at {name} differs from that a cycle of the sine before by {share:.0%}, though its amplitude "
        "has settled: subharmonic or irregular, which no frequency response holds"
    ]


def _about_short_run(result: CosimResult) -> list[str]:
    """Say where a run is too short to show whether a tracked amplitude swings."""
    frequency = result.system.excitation.frequency_Hz
    tracked = any(clamp.mode == "tracked" for clamp in result.system.clamps)
    if not tracked or not result.settles or frequency is None or is_judged(float(result.time[-1]), frequency):
        return []
    return [
        f"whether the amplitude swings for its tracker isn't judged: a fifth of the run has "
        f"{0.2 * result.time[-1] * frequency:.2g} cycles, expected at least {FEWEST_CYCLES_THAT_SWING}; "
        "use a larger stop_s"
    ]


def _step_text(result: CosimResult) -> str:
    """Give the macro steps' lengths."""
    steps = np.diff(result.time)
    if np.ptp(steps) < UNEVEN_SHARE * steps.max():
        return f"{result.step:g} s"
    return f"{steps.min():.3g} to {steps.max():.3g} s"


def _about_conditions(result: CosimResult, clamp: ClampSource) -> str:
    """Say where a law's A and f come from."""
    name = clamp.at
    amplitude, frequency = 1e3 * result.columns[f"{name}.A_used"][-1], result.columns[f"{name}.f_used"][-1]
    if amplitude != amplitude:
        return f"{name}: not one of our FMUs; it doesn't say what A and f its law was taken for"
    used = f"A = {amplitude:.4g} mm, f = {frequency:.4g} Hz"
    if clamp.mode == "solved" and result.unsolved:
        return f"{name}: A and f NOT solved in {result.runs} runs, they still change by {result.unsolved:.1%}: {used}"
    how = {"given": "as given", "solved": f"solved in {result.runs} runs", "tracked": "tracked, at the end"}[clamp.mode]
    return f"{name}: its law is taken for {used} ({how}){_about_form(result, clamp)}"


def _about_form(result: CosimResult, clamp: ClampSource) -> str:
    """Say why the A of a clamp's law isn't the amplitude that is told: that is of the peaks, A of the rms."""
    if clamp.mode == "given" or result.beats is not None:
        return ""
    displacement = result.columns[f"{clamp.at}.s"][result.time >= (1 - LAST_SHARE) * result.time[-1]]
    of_rms, of_peaks = sqrt(2) * float(np.std(displacement)), result.amplitude(f"{clamp.at}.s")
    if abs(of_rms - of_peaks) <= NOTABLE_FORM * of_peaks:
        return ""
    less = "less" if of_peaks < of_rms else "more"
    return (
        f"; A is sqrt(2) times the rms of the displacement, the amplitude is half of its peak to peak: "
        f"{abs(of_peaks / of_rms - 1):.1%} {less}, as the motion is no sine"
    )
