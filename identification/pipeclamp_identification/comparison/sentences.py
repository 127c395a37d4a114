"""Words made sentences."""

from __future__ import annotations

import math

SENTENCE_KINDS = ("warning:", "note:")
"""What says of which kind a sentence is, and names nothing."""


def sentence(words: str) -> str:
    """Give words as a sentence; a name of the catalogue that begins them stays as `add` takes it."""
    first = words.split(maxsplit=1)[0] if words.split() else ""
    named = set("_:") & set(first) and first not in SENTENCE_KINDS
    begun = words if named else f"{words[:1].upper()}{words[1:]}"
    return begun if begun.endswith(".") else f"{begun}."


def about_mean(mean_share: float, nrmse: float, noise_nrmse: float | None) -> str:
    """Say what a law errs of the force that varies, where most of the force is a constant load.

    Args:
        mean_share: share of the squared force that the runs' mean forces hold.
        nrmse, noise_nrmse: error and scatter, as shares of the rms force; scatter may be unknown.
    """
    varying = math.sqrt(1 - mean_share)
    if nrmse > varying:
        return (
            "most of the force is a constant load, which the law lacks: offset adds one that is the same in every run, "
            "condition:COLUMN one that follows a column of runs.csv"
        )
    scatter = "" if noise_nrmse is None else f", scatter {noise_nrmse / varying:.2%}"
    return f"most of the force is a constant load; of the rms of the rest the error is {nrmse / varying:.2%}{scatter}"
