"""The command line's part for what was measured on a pipe."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pipeclamp.cli.terminal import command_called, show, showing_progress


def compare_on_pipe(
    system: Path, measured: Path, json: Path | None, report: Path | None, bands: float | None = None
) -> None:
    """Hold a pipe with its clamps against what was measured on it, and say which parameter may be wrong."""
    from pipeclamp.show.on_pipe import attributed_view
    from pipeclamp_identification.attribution.attributed import attributed
    from pipeclamp_identification.attribution.compared import compare_measured
    from pipeclamp_identification.on_pipe.bands import pipe_bands, refuse_bands
    from pipeclamp_identification.workflow.next_on_pipe import after_pipe_comparison

    with showing_progress("compare") as tell:
        if bands is not None:
            refuse_bands(system, measured, bands)
        tell(f"hold {system} against {measured}")
        held = compare_measured(system, measured)
        found = attributed(held, tell)
        if bands is not None and held.sines:
            tell("bands")
            found = replace(found, bands=pipe_bands(system, held.sines, bands))
    following = after_pipe_comparison(found, str(system), str(measured), reported=report is not None)
    if report:
        from pipeclamp.pages.page import write_report
        from pipeclamp.pages.system.on_pipe import attributed_sections

        title = f"{held.system.name} against {held.description.name}"
        about = held.description.notes or "pipe and clamps"
        write_report(report, title, about, attributed_sections(found, following), command_called())
    show(attributed_view(found, following), json)
