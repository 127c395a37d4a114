"""The command line's part for the discovery of terms."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pipeclamp.cli.terminal import (
    CampaignFolder,
    DeclaredOption,
    JobsOption,
    JsonOption,
    LawArgument,
    ReportOption,
    StrictOption,
    command_called,
    file_option,
    opened_law,
    read_and_tell,
    show,
    showing_progress,
    spare,
)

app = typer.Typer()


@app.command(epilog="Example: pipeclamp discover law.json my_campaign -o term.toml --auto law2.json")
def discover(
    law: LawArgument,
    campaign: CampaignFolder,
    output: Annotated[Path, file_option("EFFECT.toml", "The declaration to write, where a term is proposed.")],
    auto: Annotated[
        Path | None,
        file_option("LAW2.json", "Write the law with the term too.", "--auto"),
    ] = None,
    json: JsonOption = None,
    report: ReportOption = None,
    declared: DeclaredOption = None,
    jobs: JobsOption = -1,
    strict: StrictOption = False,
) -> None:
    """Propose a term that no catalogue has, where a law lacks one: a formula, guarded against chance."""
    from pipeclamp.show.discovery import discovery_view
    from pipeclamp_identification.discovery.proposal import toml_of
    from pipeclamp_identification.workflow import discover as workflow
    from pipeclamp_identification.workflow.next_command import after_discovery
    from pipeclamp_models.base.files import refuse_ending, write_whole
    from pipeclamp_models.base.processes import Workers
    from pipeclamp_models.law.declaration_files import SUFFIX, read_declaration, read_effects
    from pipeclamp_models.law.file import law_text

    refuse_ending(output, SUFFIX, "a declaration")
    spare(campaign, *(declared or ()), outputs=(output, json, report, auto))
    spare(law, outputs=(output, json, report))
    with showing_progress("discover") as tell:
        file = opened_law(law)
        _, declarations = read_effects((), declared or ())
        tests = read_and_tell(campaign, strict, tell)
        found = workflow.discover(
            file, tests, command=command_called(), declared=declarations, workers=Workers(jobs, tell)
        )  # fmt: skip
    paths = {read_declaration(path).id: str(path) for path in declared or ()}
    following = after_discovery(found, law, str(campaign), str(output), str(auto) if auto else None, paths)
    if report:
        from pipeclamp.pages.discovery import discovery_page, discovery_title
        from pipeclamp.pages.page import write_report

        laws = [(one, tests.compare(one)) for one in (file, *([found.after] if found.after else []))]
        sections = discovery_page(found, laws, following)
        write_report(report, *discovery_title(file, tests.name), sections, command_called())
    if found.declaration is not None:
        write_whole(output, toml_of(found.declaration))
        if auto and found.after is not None:
            write_whole(auto, law_text(found.after))
    show(discovery_view(found, following), json)
