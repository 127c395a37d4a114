"""The JSON schemas of what is written: parameter files, and answers of commands whatever the kind of tests."""

from __future__ import annotations

import json
from typing import Any

from pydantic import TypeAdapter

from pipeclamp_identification.attribution.answer import SystemComparisonAnswer
from pipeclamp_identification.comparison.answer import ComparisonAnswer
from pipeclamp_identification.diagnosis.answer import DiagnosisAnswer
from pipeclamp_identification.discovery.proposal import DiscoveryAnswer
from pipeclamp_identification.importing.answer import ImportAnswer
from pipeclamp_identification.loops.answer import MetricsAnswer
from pipeclamp_identification.metrics_only.comparison_answer import MetricComparisonAnswer
from pipeclamp_identification.metrics_only.diagnosis_answer import MetricDiagnosisAnswer
from pipeclamp_identification.metrics_only.metrics_answer import MetricRowsAnswer
from pipeclamp_identification.planning.campaign_answer import CampaignPlanAnswer
from pipeclamp_identification.planning.narrowing_answer import BandPlanAnswer
from pipeclamp_identification.workflow.laws_answer import LawsComparisonAnswer
from pipeclamp_models.base.errors import UsageError, did_you_mean
from pipeclamp_models.law.file import LawFile
from pipeclamp_models.realise.catalogue_answer import CatalogueAnswer

WRITTEN: dict[str, tuple[Any, str]] = {
    "law": (LawFile, "parameter files, which identify and add write"),
    "metrics": (MetricsAnswer | MetricRowsAnswer, "metrics --json"),
    "comparison": (ComparisonAnswer | MetricComparisonAnswer, "compare --json of a law"),
    "laws-comparison": (LawsComparisonAnswer, "compare --json of several laws"),
    "system-comparison": (SystemComparisonAnswer, "compare --json of a coupled system"),
    "import": (ImportAnswer, "import --json"),
    "effects": (CatalogueAnswer, "effects --json"),
    "discovery": (DiscoveryAnswer, "discover --json"),
    "band-plan": (BandPlanAnswer, "plan --json of a coupled system"),
    "campaign-plan": (CampaignPlanAnswer, "plan -o --json"),
    "diagnosis": (DiagnosisAnswer | MetricDiagnosisAnswer, "diagnose --json"),
}
"""What there are schemas of, with what writes it; two kinds are of records and of metrics without records."""


def schema_text(name: str) -> str:
    """Give the JSON schema of what is written under a name.

    Raises:
        UsageError: there is no such name.
    """
    if name not in WRITTEN:
        raise UsageError(f"schema: got {name!r}; {did_you_mean(name, WRITTEN)}expected one of {', '.join(WRITTEN)}")
    schema = TypeAdapter(WRITTEN[name][0]).json_schema(by_alias=True, mode="serialization")
    return json.dumps(schema, indent=1) + "\n"
