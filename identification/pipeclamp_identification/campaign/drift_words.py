"""What is said of sensors that drift: what moves, by how much and where, what was done, and what to do."""

from __future__ import annotations

from pipeclamp_identification.campaign.faults import Channel, Done

CHANGES_AS_A_WHOLE = "the device softens or stiffens as a whole, as filled rubber does in its first cycles"
"""What does the same to a loop as a gain of the force."""


def zero_drift_words(channel: Channel, shown: str) -> str:
    """Say that a zero drifts inside records; `shown` says by how much, and in which runs."""
    stays = "its loop and its position stay" if channel == "force" else "the force doesn't follow"
    return (
        f"the zero of the {channel} channel drifts: {shown}; {stays}, so it is no spring or damper of the "
        "clamp's; the drift is taken off, and the mean force of these records counts for nothing, as nobody knows "
        "where it stood; to do: let the amplifier warm up and the specimen settle, and set the zero before each run"
    )


def zero_or_position_words(shown: str) -> str:
    """Say that either the zero of the displacement drifts inside records or the mean position does."""
    return (
        f"the zero of the displacement channel drifts, or the mean position does: {shown}; the force "
        "can't tell which, as it hardly follows the position; the runs are kept; to do: see whether the zero "
        "stays while the machine rests"
    )


def built_up_words(shown: str) -> str:
    """Say that a mean force drifts inside records as no amplifier does, for it drifts more at large amplitudes."""
    return (
        f"the mean force drifts: {shown}; its loop and its position stay, but it drifts more at large "
        "amplitudes, which no amplifier knows: something in the specimen builds up while it is worked (a pressure, "
        "heat, creep), which no law here follows; the drift is taken off, and the mean force of these records "
        "counts for nothing; to do: let it run until the mean stays, then record"
    )


def gain_drift_words(channel: Channel, shown: str, done: Done) -> str:
    """Say that a gain drifts inside records, or of the force that the device may change as a whole."""
    kept = "too many to leave out: what is said of physics may be this fault's"
    after = done if done == "left out" else kept
    if channel == "force":
        runs_in = ", so that a law doesn't know how the device runs in" if done == "left out" else ""
        return (
            f"the force changes within records, stiffness and damping in one ratio: {shown}; the gain of the force "
            f"channel drifts, or {CHANGES_AS_A_WHOLE}; {after}{runs_in}; to do: calibrate the channel; run the device "
            "in until its loop stays, and repeat these runs"
        )
    return (
        f"the gain of the displacement channel drifts: {shown}; the force stays, though it follows the amplitude from "
        f"run to run; {after}; to do: calibrate it, and repeat these runs"
    )


def gain_drift_in_run_words(channel: Channel, size: float, error: float) -> str:
    """Say of one run by how much a gain drifts in it; the fault of all such runs says what to do."""
    drifts = "stiffness and damping change" if channel == "force" else "the gain of the displacement channel changes"
    why = (
        ", in one ratio: the gain of the force channel drifts, or the device changes as a whole"
        if channel == "force"
        else ""
    )
    return f"{drifts} by {size:+.2%} (standard error {100 * error:.1g}%) from its first cycle to its last{why}"


def zero_drift_over_runs_words(channel: Channel, shown: str, order: str) -> str:
    """Say that a zero drifts from run to run; `order` says in which order of the runs."""
    return (
        f"the zero of the {channel} channel drifts from run to run: by {shown} from the first run to the last "
        f"{order}, at alike conditions; the drift is taken off, the mean of all runs is kept; to do: set the zero "
        "before each run"
    )


def gain_drift_over_runs_words(channel: Channel, shown: str, order: str) -> str:
    """Say that a gain drifts from run to run; `order` says in which order of the runs."""
    what = "the gain of the displacement channel drifts from run to run"
    doubt = "stiffness and damping in one ratio"
    remedy = "calibrate it, and repeat a first run last"
    if channel == "force":
        what = "the force changes from run to run"
        doubt += f"; the gain of the force channel drifts, or {CHANGES_AS_A_WHOLE}"
        remedy = "calibrate the channel, and repeat a first run last"
    return (
        f"{what}: by {shown} from the first run to the last {order}, alike conditions given, {doubt}; they are kept, "
        f"so that what is said of physics may be this fault's; to do: {remedy}"
    )
