"""What commands find, on campaigns of records and of metrics alike: for --json, for --report, and to be printed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pipeclamp.declaration import Declaration
from pipeclamp.errors import UserError
from pipeclamp.parameter_file import LawFile
from pipeclamp_identification import comparison_report, diagnosis_report, metric_diagnosis_report, metric_law
from pipeclamp_identification.add import Addition
from pipeclamp_identification.campaign import Campaign
from pipeclamp_identification.compare import Comparison, compare, comparison_json, where_words
from pipeclamp_identification.comparison_report import parts_table
from pipeclamp_identification.diagnosis_report import Answer
from pipeclamp_identification.fit import Progress
from pipeclamp_identification.identify import Method, identify, law_file
from pipeclamp_identification.identify_report import identification_sections, law_sections
from pipeclamp_identification.loops import loops_of
from pipeclamp_identification.metric_campaign import MetricCampaign
from pipeclamp_identification.metric_diagnosis_report import MetricAnswer
from pipeclamp_identification.metric_writing import as_metrics, metric_rows, metric_table
from pipeclamp_identification.metrics_report import metrics_sections
from pipeclamp_identification.metrics_summary import metrics_json
from pipeclamp_identification.pipe_attribution import attribute
from pipeclamp_identification.pipe_attribution_report import (
    attribution_json,
    attribution_section,
    attribution_words,
    candidate_table,
)
from pipeclamp_identification.pipe_compared import Compared
from pipeclamp_identification.pipe_comparison import PipeComparison
from pipeclamp_identification.pipe_comparison_report import pipe_comparison_sections, probe_table
from pipeclamp_identification.pipe_next_test import propose
from pipeclamp_identification.pipe_records import RecordsComparison, records_json, records_words
from pipeclamp_identification.pipe_records_report import records_sections
from pipeclamp_identification.pipe_where import how_much, pipe_comparison_json
from pipeclamp_identification.pipe_where import where_words as where_on_pipe
from pipeclamp_identification.report import Section, Table

SHOWN = 8
"""Runs of a comparison that are printed, worst first."""


@dataclass(frozen=True)
class Findings:
    """What a command found.

    Attributes:
        answer: for --json.
        sections: for --report; none where no report is wanted.
        tables: printed.
        lines: printed, most important first.
    """

    answer: dict[str, Any]
    sections: Sequence[Section]
    tables: Sequence[Table]
    lines: Sequence[str]


def metrics_found(tests: Campaign | MetricCampaign) -> tuple[Findings, MetricCampaign]:
    """Give the metrics of a campaign's loops, and the campaign that is left of it without its records."""
    if isinstance(tests, MetricCampaign):
        table = metric_table(tests)
        lines = (f"{len(tests.runs)} runs, known by their metrics alone",)
        return Findings({"runs": metric_rows(tests)}, [Section("All runs", (), [table])], [table], lines), tests
    loops = loops_of(tests)
    sections = metrics_sections(tests, loops)
    tables = [table for section in sections[:-1] for table in section.tables]
    lines = (f"{len(tests.runs)} runs; every run is in --json and --report",)
    return Findings(metrics_json(tests, loops), sections, tables, lines), as_metrics(tests, loops)


def identified(
    tests: Campaign | MetricCampaign,
    *,
    base: str,
    effects: Sequence[str],
    frozen: Mapping[str, float],
    method: Method,
    declared: Sequence[Declaration],
    name: str,
    command: str,
    date: str | None,
    with_report: bool,
    progress: Progress,
) -> tuple[LawFile, Sequence[Section]]:
    """Identify a law; give its file and the report.

    Raises:
        UserError: the tests can't serve the law.
    """
    if isinstance(tests, MetricCampaign):
        if method != "joint":
            raise UserError(f"method {method}: {tests.name} holds metrics without records; expected the joint method")
        result = metric_law.identify_metrics(
            tests, base=base, effects=effects, frozen=frozen, declared=declared, progress=progress
        )
        file = metric_law.metric_law_file(result, tests, name=name, command=command, date=date)
        held = metric_law.compare_metrics(file, tests)
        sections = (
            [*law_sections(result.law, file), *metric_law.metric_comparison_sections(held)] if with_report else []
        )
        return file, sections
    found = identify(
        tests, base=base, effects=effects, frozen=frozen, method=method, declared=declared, progress=progress
    )
    file = law_file(found, tests, name=name, command=command, date=date)
    comparison = Comparison(found.fit.law, tests, found.loops, found.misfits, {})
    return file, identification_sections(file, comparison) if with_report else []


def compared(file: LawFile, tests: Campaign | MetricCampaign, *, with_report: bool) -> Findings:
    """Hold a law against tests.

    Raises:
        UserError: the law needs a condition that the tests don't state.
    """
    if isinstance(tests, MetricCampaign):
        held = metric_law.compare_metrics(file, tests)
        return Findings(
            metric_law.metric_comparison_json(held),
            metric_law.metric_comparison_sections(held) if with_report else [],
            [metric_law.metric_worst_table(held, most=SHOWN)],
            metric_law.metric_comparison_words(held),
        )
    comparison = compare(file, tests)
    return Findings(
        comparison_json(comparison),
        comparison_report.comparison_sections(comparison) if with_report else [],
        [comparison_report.worst_table(comparison, most=SHOWN)],
        [*comparison_report.how_much(comparison), *where_words(comparison)],
    )


def compared_on_pipe(compared: Compared, *, with_report: bool, progress: Progress) -> Findings:
    """Give how a coupled model stands against what was measured on the pipe, and which parameter may be wrong."""
    found = attribute(compared, progress)
    proposal = None
    if found is not None and found.verdict == "ambiguous":
        progress("look for a test that would tell")
        proposal = propose(found, compared)
    parts = [
        *([_on_sines(compared.sines, with_report=with_report)] if compared.sines else []),
        *([_on_records(compared.records, with_report=with_report)] if compared.records else []),
    ]
    answer = parts[0].answer | ({"over_time": parts[1].answer} if len(parts) > 1 else {})
    sections: list[Section] = []
    if with_report:
        how, *others = [section for part in parts for section in part.sections]
        sections = [how, attribution_section(found, proposal), *others]
    return Findings(
        answer | {"attribution": found and attribution_json(found, proposal)},
        sections,
        [*(table for part in parts for table in part.tables), *([candidate_table(found, most=SHOWN)] if found else [])],
        [*(line for part in parts for line in part.lines), *attribution_words(found, proposal)],
    )


def _on_sines(comparison: PipeComparison, *, with_report: bool) -> Findings:
    """Give how a coupled model stands against sines."""
    return Findings(
        pipe_comparison_json(comparison),
        pipe_comparison_sections(comparison) if with_report else [],
        [probe_table(comparison)],
        [*how_much(comparison), *where_on_pipe(comparison)],
    )


def _on_records(comparison: RecordsComparison, *, with_report: bool) -> Findings:
    """Give how a coupled model stands against records of any motion."""
    return Findings(
        records_json(comparison),
        records_sections(comparison) if with_report else [],
        [parts_table(parts) for parts in comparison.breakdowns()],
        records_words(comparison),
    )


def diagnosed(answer: Answer | MetricAnswer, *, with_report: bool, additions: Sequence[Addition] = ()) -> Findings:
    """Give a diagnosis, and what was added before it; the first line is its verdict."""
    following = [f"Next: {answer.proposal.words()}"] if answer.proposal else []
    added = [
        {"effect": one.effect, "heldout_nrmse": {"before": one.heldout[0], "after": one.heldout[1]}}
        for one in additions
    ]
    if isinstance(answer, MetricAnswer):
        return Findings(
            {**metric_diagnosis_report.metric_answer_json(answer), "added": added},
            metric_diagnosis_report.metric_answer_sections(answer) if with_report else [],
            [metric_diagnosis_report.metric_candidate_table(answer.diagnosis)],
            [answer.headline(), *(f"  {word}" for word in answer.words()), *following],
        )
    words = (*answer.diagnosis.reasons, *answer.left_over())
    return Findings(
        {**diagnosis_report.answer_json(answer), "added": added},
        diagnosis_report.answer_sections(answer) if with_report else [],
        [diagnosis_report.candidate_table(answer.diagnosis)],
        [answer.headline(), *(f"  {word}" for word in words), *following],
    )
