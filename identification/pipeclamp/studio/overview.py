"""What the first screen says: how far a law errs, how it came there, what is missing, what to do next."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from pipeclamp.pages.alternative import words_of
from pipeclamp.pages.page import least_width, specification_of
from pipeclamp.pages.waterfall import ESTIMATED, USED, RungBars, rungs_of, waterfall_picture, with_promised
from pipeclamp.show.comparison import how_much
from pipeclamp.show.law import parameters_table, vain_words
from pipeclamp.show.table import cell
from pipeclamp.studio.bench import Bench
from pipeclamp.studio.diagnosis_shown import DiagnosisShown, stamp
from pipeclamp.studio.error_map import ErrorMap, error_map
from pipeclamp.studio.project import SHOWN, Project
from pipeclamp.studio.sliders import Slider, candidate_sliders, sliders_of
from pipeclamp_identification.comparison.conditions import conditions_of
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import LawFile

NO_TITLE = 45
"""px that the waterfall's title takes, which stands above it here."""


@dataclass(frozen=True)
class Picture:
    """What Plotly draws, as JSON, what it shows in words, and the least width in px."""

    specification: str
    words: str
    least_width: int


@dataclass(frozen=True)
class LawChip:
    """A law in the list of laws."""

    name: str
    words: str
    error: float | None
    parent: str | None


@dataclass(frozen=True)
class LawShown:
    """A law as its page shows it.

    Attributes:
        name: law1, law2, ...
        title: its base and effects.
        error, scatter: percent of the rms force.
        words: what is to know of that, as of tests of which most is a constant load.
        vain: that what was added last doesn't help; empty where it does.
        waterfall: its history.
        map, before: of the error; that of the law before it, where there is one on the same tests.
        diagnosis: of it, where one was made.
        once: runs that it was fitted to, where the tests have changed since.
        groups: its parameters, by effect.
    of_candidates: those that each candidate of the diagnosis would add, by its name.
    """

    name: str
    title: str
    error: float
    scatter: float | None
    words: tuple[str, ...]
    vain: str
    waterfall: Picture
    map: ErrorMap
    before: ErrorMap | None
    diagnosis: DiagnosisShown | None
    once: int | None
    groups: tuple[tuple[str, tuple[Slider, ...]], ...]
    of_candidates: Mapping[str, tuple[Slider, ...]]


def law_shown(project: Project, bench: Bench, name: str, by: str = "") -> LawShown:
    """Give a law as its page shows it.

    Args:
        project, bench: the campaign.
        name: of the law.
        by: key of the condition that the map's panels are levels of.

    Raises:
        UserError: there is no such law, or it can't be held against the tests.
    """
    file = project.law(name)
    held = bench.held(file)
    shown = error_map(bench.loops.run, held.conditions, held.sums, by)
    parent, diagnosis = project.parent(name), diagnosis_in(project, name, file)
    scatter = held.known_noise
    return LawShown(
        name=name,
        title=law_title(file),
        error=100 * held.nrmse,
        scatter=None if scatter is None else 100 * scatter,
        words=tuple(how_much(held)[1:]),
        vain=_vain(file, project.law(parent) if parent else None),
        waterfall=waterfall_of(file, diagnosis),
        map=shown,
        before=law_map(project, bench, parent, shown.by) if parent else None,
        diagnosis=diagnosis,
        once=None if file.data.fingerprint == bench.tests.campaign.fingerprint else file.data.runs_used,
        groups=sliders_of(file),
        of_candidates={each.name: candidate_sliders(file, each) for each in diagnosis.candidates} if diagnosis else {},
    )


def law_map(project: Project, bench: Bench, name: str, by: str) -> ErrorMap:
    """Give the map of a law."""
    held = bench.held(project.law(name))
    return error_map(bench.loops.run, held.conditions, held.sums, by)


def tests_map(bench: Bench, by: str = "") -> ErrorMap:
    """Give the map of tests that no law was fitted to yet."""
    return error_map(bench.loops.run, conditions_of(bench.tests.campaign, bench.loops), None, by)


def law_title(file: LawFile) -> str:
    """Give base and effects of a law."""
    return " + ".join((file.base, *file.effects))


def chips_of(project: Project) -> list[LawChip]:
    """Give all laws; those that can't be read any more are left out."""
    chips = []
    for name in project.laws():
        try:
            file = project.law(name)
        except UserError:
            continue
        error = 100 * file.fit.nrmse if file.fit else None
        parent = project.parent(name)
        words = steps_since(file, project.law(parent) if parent else None)
        chips.append(LawChip(name, words, error, parent))
    return chips


def steps_since(file: LawFile, before: LawFile | None) -> str:
    """Say by which steps a law came from another; by its last one where it didn't."""
    return " ".join(_since(file, before)) or law_title(file)


def _since(file: LawFile, before: LawFile | None) -> list[str]:
    steps = [entry.step for entry in file.history]
    # a law that nothing was done to yet has no history, and is the first step of another's
    first = [entry.step for entry in before.history] or steps[:1] if before else []
    return steps[len(first) :] if first and steps[: len(first)] == first else steps[-1:]


def _vain(file: LawFile, before: LawFile | None) -> str:
    """Say that what was added to the law before doesn't help; empty where it does."""
    return vain_words(file.history, len(_since(file, before)))


def waterfall_of(file: LawFile, diagnosis: DiagnosisShown | None) -> Picture:
    """Give a law's history as bars, and what would come next by a diagnosis, as its page has it."""
    rungs = rungs_of(file)
    if not rungs and file.fit:
        rungs = [RungBars(file.base, {USED: file.fit.nrmse})]
    if diagnosis and rungs:
        coming = [
            RungBars(each.label, {ESTIMATED: each.heldout_nrmse}, True, each.explained) for each in diagnosis.promised
        ]
        rungs = with_promised(rungs, RungBars("law as it is", {ESTIMATED: diagnosis.heldout_nrmse}), coming)
    figure = waterfall_picture(rungs, file.fit.noise_nrmse if file.fit else None, "")
    specification = specification_of(figure)
    layout = specification["layout"]
    del layout["height"]  # it fills its place
    layout |= {"title": None, "margin": layout["margin"] | {"t": 10, "b": 75}}
    layout["yaxis"]["title"] = {"text": "% of rms force"}
    narrow = specification["narrow"]["layout"]
    narrow |= {"title": None, "height": narrow["height"] - NO_TITLE, "margin": narrow["margin"] | {"t": 25}}
    return Picture(json.dumps(specification), words_of(figure), least_width(figure))


def diagnosis_in(project: Project, name: str, file: LawFile) -> DiagnosisShown | None:
    """Give the diagnosis of a law as it is shown; None where it wasn't diagnosed, or another law of that name was."""
    path = project.folder / f"{name}{SHOWN}"
    try:
        diagnosis = DiagnosisShown.model_validate_json(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValidationError, UnicodeDecodeError):
        return None
    return diagnosis if diagnosis.law_command == stamp(file) else None


def side_by_side(one: LawFile, other: LawFile) -> list[tuple[str, str, str, str]]:
    """Give the parameters of two laws: name, value with standard error in each, unit."""
    rows = parameters_table([one, other]).rows
    return [(str(name), cell(first), cell(second), str(unit)) for name, unit, first, second in rows]
