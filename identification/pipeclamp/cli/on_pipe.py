"""The command line's part for what was measured on a pipe; nothing is computed here."""

from __future__ import annotations

from pathlib import Path

from pipeclamp.cli.terminal import show, told


def compare_on_pipe(system: Path, measured: Path, json: Path | None, report: Path | None) -> None:
    """Hold a pipe with its clamps against what was measured on it, and say which parameter may be wrong."""
    from pipeclamp.show.on_pipe import attributed_view
    from pipeclamp_identification.attribution.attributed import attributed
    from pipeclamp_identification.attribution.compared import compare_measured

    with told("compare") as tell:
        tell(f"hold {system} against {measured}")
        held = compare_measured(system, measured)
        found = attributed(held, tell)
    if report:
        from pipeclamp.pages.on_pipe import attributed_sections
        from pipeclamp.pages.page import write_report

        title = f"{held.system.name} against {held.description.name}"
        write_report(report, title, held.description.notes or "pipe and clamps", attributed_sections(found))
    show(attributed_view(found), json)
