"""The command line's part for what was measured on a pipe."""

from __future__ import annotations

from pathlib import Path

from pipeclamp.cli.terminal import command_called, show, showing_progress


def compare_on_pipe(
    system: Path, measured: Path, json: Path | None, report: Path | None, bands: float | None = None
) -> None:
    """Hold a pipe with its clamps against what was measured on it, and say which parameter may be wrong."""
    from pipeclamp.show.on_pipe import attributed_view
    from pipeclamp_identification.workflow.systems.held import hold_on_pipe
    from pipeclamp_identification.workflow.systems.next_on_pipe import after_pipe_comparison

    with showing_progress("compare") as tell:
        found = hold_on_pipe(system, measured, bands, tell)
    following = after_pipe_comparison(found, str(system), str(measured), reported=report is not None)
    if report:
        from pipeclamp.pages.page import write_report
        from pipeclamp.pages.system.on_pipe import attributed_page

        write_report(report, *attributed_page(found, following), command_called())
    show(attributed_view(found, following), json)
