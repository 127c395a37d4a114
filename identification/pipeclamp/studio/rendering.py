"""Pages as text, from templates."""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from typing import Any

import jinja2

from pipeclamp.api.tests import Tests
from pipeclamp.pages.page import drawn_of, templates_of
from pipeclamp.pages.sweeps import of_energy, sweep_sections
from pipeclamp.pages.waterfall import USED, RungBars, waterfall_picture
from pipeclamp.show.metrics import MEANINGS_STATED, metric_campaign_words, metric_table
from pipeclamp.show.of_rig import of_rig_words
from pipeclamp.show.table import cell
from pipeclamp.studio import commands, overview
from pipeclamp.studio.desk import Desk, Opened, OpenedMetrics
from pipeclamp.studio.diagnosis_shown import DiagnosisShown
from pipeclamp.studio.discovering import discovery_in
from pipeclamp.studio.error_map import EDGES
from pipeclamp.studio.on_pipe import shown_on_pipe, temperatures_of
from pipeclamp.studio.project import RESPONSE_SHOWN, Project
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.diagnosis.thresholds import FEWEST_GROUPS
from pipeclamp_identification.fitting.heldout import count_groups
from pipeclamp_identification.workflow.next_command import after_change, after_identification, after_import
from pipeclamp_identification.workflow.on_metrics import MetricTests
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.base.digits import one_digit
from pipeclamp_models.base.errors import UserError

LINES_OF_A_LAW = ("diagnose", "diagnosed", "refit", "climb", "discover", "report", "respond", "build")
"""Buttons of a campaign's page that do something with its law."""


def campaign_page(opened: Opened, name: str | None, *, by: str, beside: str) -> str:
    """Give the page of a campaign with a law.

    Args:
        opened: the campaign.
        name: of the law; the newest by default.
        by: key of the condition that the map's panels are levels of.
        beside: another law to set beside it; empty for none.

    Raises:
        UserError: there is no such law.
    """
    project, bench = opened.project, opened.bench
    chips = overview.chips_of(project)
    name = name or (chips[-1].name if chips else None)
    shown = overview.law_shown(project, bench, name, by) if name else None
    other = overview.law_shown(project, bench, beside, shown.map.by) if beside and shown else None
    first_map = shown.map if shown else overview.tests_map(bench, by)
    worst = first_map.worst()
    diagnosis = shown.diagnosis if shown else None
    return page(
        "campaign.html.jinja",
        key=opened.key,
        campaign=bench.tests.name,
        summary=_summary(bench.tests),
        notes=[*map(str, bench.tests.left_out), *bench.tests.remarks],
        chips=chips,
        law=shown,
        other=other,
        side_by_side=overview.side_by_side(project.law(shown.name), project.law(other.name)) if shown and other else [],
        map=first_map,
        edges=EDGES,
        worst=worst.runs[0] if worst else "",
        diagnosis=diagnosis,
        groups=count_groups(bench.loops),
        fewest_groups=FEWEST_GROUPS,
        runs=len(bench.loops.run),
        lines=_command_lines(project, name, diagnosis),
        discovery=discovery_in(project, name, project.law(name)) if name else None,
        bases=commands.BASES,
        steps=project.steps,
        of_rig=of_rig_words(project.law(name)) if name else "",
        parent=project.parent(name) if name else None,
        folder=project.folder,
        temperatures=temperatures_of(bench.loops),
        on_pipe=shown_on_pipe(project.folder / f"{name}{RESPONSE_SHOWN}") if name else None,
        made={suffix for suffix in ("fmu", "html") if name and (project.folder / f"{name}.{suffix}").is_file()},
    )


def _command_lines(project: Project, name: str | None, diagnosis: DiagnosisShown | None) -> dict[str, Any]:
    """Give the command that each button of a campaign's page runs; empty where there is no law to run it with."""
    identify = {base: commands.identify_line(project, project.upcoming, base) for base in commands.BASES}
    if name is None:
        return {"identify": identify, "add": {}, **dict.fromkeys(LINES_OF_A_LAW, "")}
    diagnose = commands.diagnose_line(project, name)
    return {
        "identify": identify,
        "add": {
            each.name: commands.add_line(project, name, each.name, diagnosis.meant(each.name), project.upcoming)
            for each in diagnosis.candidates
        }
        if diagnosis
        else {},
        "diagnose": diagnose,
        "diagnosed": _last_diagnosis(project, name) or diagnose,
        "refit": commands.refit_line(project, name, project.upcoming),
        "climb": commands.climb_line(project, name, project.upcoming),
        "discover": commands.discover_line(project, name, project.upcoming),
        "report": commands.report_line(project, name),
        "respond": commands.response_line(project, name),
        "build": commands.build_line(project, name),
    }


def metrics_page(opened: OpenedMetrics) -> str:
    """Give the page of a campaign of metrics: what was measured, and the commands that go on; it has no loops."""
    tests, campaign = opened.tests, opened.campaign
    drawn = [
        {"title": section.title, "words": section.paragraphs, "pictures": [drawn_of(one) for one in section.figures]}
        for section in sweep_sections(tests.campaign, of_energy(tests.campaign))
    ]
    first = after_import(campaign)
    lines = [first, after_identification("law.json", campaign), after_change("law.json", campaign)]
    return page(
        "metrics.html.jinja",
        campaign=tests.name,
        summary=_summary(tests),
        notes=[*map(str, tests.left_out), *tests.remarks],
        words=[metric_campaign_words(tests.campaign), MEANINGS_STATED],
        drawn=drawn,
        table=metric_table(tests.campaign),
        lines=lines,
    )


def _last_diagnosis(project: Project, law: str) -> str:
    """Give the command that diagnosed a law last."""
    done = [step.command for step in project.steps if step.of == law and step.law is None]
    return next((command for command in reversed(done) if command.startswith("pipeclamp diagnose")), "")


def warm_drawing() -> None:
    """Make what every campaign's page needs, while the campaign is read: templates, and what draws pictures."""
    _environment().get_template("campaign.html.jinja")
    _environment().get_template("parts.html.jinja")
    waterfall_picture([RungBars("", {USED: 0.0})], 0.0, "").to_json()


def warm(desk: Desk) -> None:
    """Make what the first page needs, before it is asked for."""
    with suppress(UserError):  # whoever asks is told
        opened = desk.open(desk.first) if desk.first else None
        if isinstance(opened, Opened):
            campaign_page(opened, None, by="", beside="")


def _summary(tests: RecordTests | MetricTests) -> str:
    """Say how many runs there are, and over which conditions."""
    summary = str(Tests(tests, tests.name)).splitlines()[0]
    return summary.removeprefix(f"{tests.name}: ")


def page(template: str, **content: Any) -> str:
    """Give a page as text."""
    return _environment().get_template(template).render(**content)


@cache
def _environment() -> jinja2.Environment:
    environment = templates_of("pipeclamp.studio")
    environment.filters["cell"] = cell
    environment.filters["percent"] = lambda value: f"{value:.2f}%" if value >= 0.995 else f"{value:.2g}%"
    environment.filters["sentence"] = sentence
    environment.filters["one_digit"] = one_digit
    environment.filters["named"] = commands.effects_said
    return environment
