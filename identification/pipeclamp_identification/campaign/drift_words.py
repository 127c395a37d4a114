"""What is said of sensors that drift: what moves, by how much and where, what was done, and what to do."""

from __future__ import annotations

from pipeclamp_identification.campaign.faults import Channel, Done


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
    """Say that a gain drifts inside records."""
    why = (
        "stiffness and damping change in one ratio, as no effect does to both"
        if channel == "force"
        else "the force stays, though it follows the amplitude from run to run"
    )
    kept = "too many to leave out: what is said of physics may be this fault's"
    return (
        f"the gain of the {channel} channel drifts: {shown}; {why}; {done if done == 'left out' else kept}; to do: "
        "calibrate it, and repeat these runs"
    )


def zero_drift_over_runs_words(channel: Channel, shown: str, order: str) -> str:
    """Say that a zero drifts from run to run; `order` says in which order of the runs."""
    return (
        f"the zero of the {channel} channel drifts from run to run: by {shown} from the first run to the last "
        f"{order}, at alike conditions; the drift is taken off, the mean of all runs is kept; to do: set the zero "
        "before each run"
    )


def gain_drift_over_runs_words(channel: Channel, shown: str, order: str) -> str:
    """Say that a gain drifts from run to run; `order` says in which order of the runs."""
    return (
        f"the gain of the {channel} channel drifts from run to run: by {shown} from the first run to the last {order}, "
        "alike conditions given, stiffness and damping in one ratio; they are kept, so that what is said of physics "
        "may be this fault's; to do: calibrate it, and repeat a first run last"
    )
