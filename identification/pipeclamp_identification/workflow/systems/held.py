"""A coupled system held against what was measured on its pipe."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pipeclamp_identification.attribution.attributed import Attributed, attributed
from pipeclamp_identification.attribution.compared import compare_measured
from pipeclamp_identification.on_pipe.bands import pipe_bands, refuse_bands
from pipeclamp_models.base.progress import Progress, silent


def hold_on_pipe(
    system: Path, measured: Path, per_cent: float | None = None, progress: Progress = silent
) -> Attributed:
    """Hold a pipe with its clamps against what was measured on it, and say which parameter may be wrong.

    Args:
        system: SYSTEM.toml.
        measured: folder with measurement.toml.
        per_cent: that the model's bands at measured sines are to hold, such as 95; None for none.
        progress: is told what is being done.

    Raises:
        UserError: the system or the measurement can't be read, or no law tells how sure it is.
        UsageError: the share can't be held by a band.
    """
    if per_cent is not None:
        refuse_bands(system, measured, per_cent)
    progress(f"hold {system} against {measured}")
    held = compare_measured(system, measured)
    found = attributed(held, progress)
    if per_cent is None or not held.sines:
        return found
    progress("bands")
    return replace(found, bands=pipe_bands(system, held.sines, per_cent))
