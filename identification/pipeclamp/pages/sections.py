"""Pages of what was found, whatever the kind of tests: the answer first, then the difference, then the details."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import singledispatch

import plotly.graph_objects as go

from pipeclamp.pages.comparison import answer_words, detail_sections, difference_section
from pipeclamp.pages.diagnosis import diagnosis_answer, evidence_sections, promised
from pipeclamp.pages.law import law_sections
from pipeclamp.pages.metric_diagnosis import metric_diagnosis_answer, metric_promised
from pipeclamp.pages.metrics import metric_campaign_sections, metrics_sections
from pipeclamp.pages.page import Section
from pipeclamp.pages.sweeps import of_energy_and_law, sweep_sections
from pipeclamp.pages.waterfall import OF_FORCE, OF_METRICS, RungBars, rungs_of, waterfall_picture, with_promised
from pipeclamp.show.law import fit_words, laws_table, least_words, parameters_table, stages_table, vain_words
from pipeclamp.show.metric_comparison import metric_comparison_words, metric_worst_table
from pipeclamp.show.views import known_scatter_of
from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.comparison.laws import laws_held, least_error, stages_held
from pipeclamp_identification.comparison.names import labels_of
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed
from pipeclamp_identification.metrics_only.law import MetricComparison
from pipeclamp_identification.workflow.climb import Rung
from pipeclamp_identification.workflow.on_metrics import MetricTests
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_identification.workflow.tests import Diagnosed, Held, Tests
from pipeclamp_models.law.file import LawFile


@dataclass(frozen=True)
class _Parts:
    """A diagnosis's answer, the law against the tests, the rungs from it on, and the evidence."""

    answer: Section
    held: Held
    rungs: Sequence[RungBars]
    evidence: Sequence[Section]


@singledispatch
def _answer(held: object) -> list[str]:
    raise TypeError(f"no page of {type(held).__name__}")


@singledispatch
def _details(held: object) -> list[Section]:
    raise TypeError(f"no page of {type(held).__name__}")


@_answer.register
def _(held: Comparison) -> list[str]:
    return answer_words(held)


@_answer.register
def _(held: MetricComparison) -> list[str]:
    return metric_comparison_words(held)


@_details.register
def _(held: Comparison) -> list[Section]:
    return detail_sections(held)


@_details.register
def _(held: MetricComparison) -> list[Section]:
    drawn = sweep_sections(held.campaign, of_energy_and_law(held))
    return [*drawn, Section("All runs", (), [metric_worst_table(held)])]


@singledispatch
def _diagnosed(found: object) -> _Parts:
    raise TypeError(f"no page of {type(found).__name__}")


@_diagnosed.register
def _(found: RecordDiagnosed) -> _Parts:
    return _Parts(diagnosis_answer(found), found.comparison, promised(found.diagnosis), evidence_sections(found))


@_diagnosed.register
def _(found: MetricDiagnosed) -> _Parts:
    return _Parts(metric_diagnosis_answer(found), found.comparison, metric_promised(found.diagnosis), [])


def comparison_page(laws: Sequence[tuple[LawFile, Held]], next_command: str = "") -> list[Section]:
    """Give the page of laws held against the same tests; what isn't drawn of all is of the one that errs least.

    Args:
        laws: each law's file, and how it stands; of a single law the stages of its history are shown too.
        next_command: the shell line to run next.
    """
    best = least_error([against for _, against in laws])
    file, held = laws[best]
    words, tables = _answer(held), []
    if len(laws) > 1:
        words = [least_words([one for one, _ in laws], best), *words]
        tables = [laws_table([(one, against.nrmse, known_scatter_of(against)) for one, against in laws])]
    answer = Section("Answer", words, tables, _falling(file, ()), next_command)
    return [answer, *laws_sections(laws, best)]


def laws_sections(laws: Sequence[tuple[LawFile, Held]], about: int) -> list[Section]:
    """Give difference, parameters, and details of the law at a place, of laws held against the same tests."""
    file, held = laws[about]
    files = [one for one, _ in laws]
    details, parameters = _details(held), stages_table(file)
    if len(laws) > 1:
        label = labels_of(files)[about]
        details = [replace(section, paragraphs=[f"Of {label}.", *section.paragraphs]) for section in details]
        parameters = parameters_table(files)
    further = [Section("Parameters", (), [parameters])] if parameters else []
    return [*_difference(laws, about), *details, *further]


def comparison_title(files: Sequence[LawFile], tests: str) -> tuple[str, str]:
    """Give title and subtitle of the page of laws held against the tests of that name."""
    *others, last = files
    made_of = f"base {last.base}, effects: {', '.join(last.effects) or 'none'}"
    if not others:
        return f"Law {last.name} against {tests}", made_of
    return f"{len(files)} laws against {tests}", "; ".join(labels_of(files))


def diagnosis_title(file: LawFile, tests: str) -> tuple[str, str]:
    """Give title and subtitle of the page of a law's diagnosis on the tests of that name."""
    return f"Diagnosis of {file.name}", f"against {tests}"


def diagnosis_page(file: LawFile, found: Diagnosed, next_command: str, ladder: Sequence[Rung] = ()) -> list[Section]:
    """Give the page of a diagnosis, with the command to run next below its verdict.

    Args:
        file: the law.
        found: the diagnosis.
        next_command: the shell line to run next.
        ladder: what --auto did before it.
    """
    parts = _diagnosed(found)
    how_much, *where = _answer(parts.held)
    words = [*parts.answer.paragraphs, how_much]
    figures = [*_falling(file, parts.rungs), *parts.answer.figures]
    answer = replace(parts.answer, paragraphs=words, figures=figures, command=next_command)
    difference = _difference([(file, parts.held)], 0)
    if difference and (found.verdict == "unknown" or found.kind == "part"):
        # what is left over is the first thing to look at
        answer, difference = replace(answer, explorer=difference[0].explorer), []
    places = [Section("Where", where)] if where else []
    rungs = [Section("Rungs", rung_words(ladder))] if ladder else []
    return [answer, *rungs, *difference, *parts.evidence, *places, *_details(parts.held)]


def rung_words(ladder: Sequence[Rung]) -> list[str]:
    """Say of each rung of a ladder what it did to the error, and what to mind of it."""
    return [" ".join(map(sentence, (f"{number}: {rung.said()}", *rung.words))) for number, rung in enumerate(ladder, 1)]


def law_page(file: LawFile, held: Held, next_command: str = "") -> list[Section]:
    """Give the page of a law and of how it stands against its tests, with the shell line to run next."""
    answer = Section("Answer", _answer(held), figures=_falling(file, ()), command=next_command)
    return [answer, *_difference([(file, held)], 0), *law_sections(file), *_details(held)]


def law_alone_page(file: LawFile, steps: int = 1) -> list[Section]:
    """Give the page of a law without tests: how its error fell, its equations, parameters and surfaces.

    Args:
        file: the law.
        steps: how many of the last steps of its history were taken at once.
    """
    vain = vain_words(file.history, steps)
    words = [
        *([f"Against its own data: {fit_words(file.fit)}."] if file.fit else []), *([f"{vain}."] if vain else [])
    ]  # fmt: skip
    figures = _falling(file, ())
    answer = [Section("Answer", words, figures=figures)] if words or figures else []
    return [*answer, *law_sections(file)]


def metrics_page(tests: Tests, next_command: str = "") -> list[Section]:
    """Give the page of tests by their loop metrics, the shell line to run next in its first section.

    Raises:
        TypeError: tests of a kind that has none.
    """
    if isinstance(tests, RecordTests):
        first, *others = metrics_sections(tests.sines, tests.loops)
    elif isinstance(tests, MetricTests):
        first, *others = metric_campaign_sections(tests.campaign)
    else:
        raise TypeError(f"no page of the metrics of {type(tests).__name__}")
    return [replace(first, command=next_command), *others]


def _difference(laws: Sequence[tuple[LawFile, Held]], about: int) -> list[Section]:
    """Show records less laws, or less the stages of the only one; metrics alone hold no difference to show."""
    file, held = laws[about]
    if not isinstance(held, Comparison) or not held.runs:
        return []
    records = [(one, against) for one, against in laws if isinstance(against, Comparison)]
    return [difference_section(held, laws_held(records) if len(records) > 1 else stages_held(file, held))]


def _falling(file: LawFile, next_rungs: Sequence[RungBars]) -> list[go.Figure]:
    """Draw a law's way, or its only step, and what would come next.

    Args:
        file: the law.
        next_rungs: the law as it is, by a diagnosis, and what effects would do to it.
    """
    rungs = rungs_of(file)
    if next_rungs:
        now, *coming = next_rungs
        rungs = with_promised(rungs, now, coming)
    if not rungs:
        return []
    fit = file.fit
    axis = OF_METRICS if fit and fit.of_metrics else OF_FORCE
    return [waterfall_picture(rungs, fit.noise_nrmse if fit else None, "The error, effect by effect", axis)]
