"""Pages of what was found, whatever the kind of tests: sections of words, tables and pictures."""

from __future__ import annotations

from dataclasses import replace
from functools import singledispatch

from pipeclamp.pages.comparison import comparison_sections
from pipeclamp.pages.diagnosis import diagnosis_sections
from pipeclamp.pages.law import law_sections
from pipeclamp.pages.metric_comparison import metric_comparison_sections
from pipeclamp.pages.metric_diagnosis import metric_diagnosis_sections
from pipeclamp.pages.metrics import metrics_sections
from pipeclamp.pages.page import Section
from pipeclamp.show.metrics import metric_table
from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.diagnosis.diagnosed import Diagnosed
from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed
from pipeclamp_identification.metrics_only.law import MetricComparison
from pipeclamp_identification.workflow.on_metrics import MetricTests
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_identification.workflow.tests import Held
from pipeclamp_models.law.file import LawFile


@singledispatch
def sections_of(found: object) -> list[Section]:
    """Give the page of a comparison or a diagnosis, or of tests by their metrics."""
    raise TypeError(f"no page of {type(found).__name__}")


@sections_of.register
def _(found: Comparison) -> list[Section]:
    return comparison_sections(found)


@sections_of.register
def _(found: MetricComparison) -> list[Section]:
    return metric_comparison_sections(found)


@sections_of.register
def _(found: Diagnosed) -> list[Section]:
    return diagnosis_sections(found)


@sections_of.register
def _(found: MetricDiagnosed) -> list[Section]:
    return metric_diagnosis_sections(found)


@sections_of.register
def _(found: RecordTests) -> list[Section]:
    return metrics_sections(found.sines, found.loops)


@sections_of.register
def _(found: MetricTests) -> list[Section]:
    return [Section("All runs", (), [metric_table(found.campaign)])]


def diagnosis_page(found: object, next_command: str) -> list[Section]:
    """Give the page of a diagnosis, with the command to run next below its verdict."""
    verdict, *others = sections_of(found)
    return [replace(verdict, paragraphs=[*verdict.paragraphs, f"Next: {next_command}"]), *others]


def law_page(file: LawFile, held: Held) -> list[Section]:
    """Give the page of a law and of how it stands against the tests that it was fitted to."""
    return [*law_sections(file), *sections_of(held)]
