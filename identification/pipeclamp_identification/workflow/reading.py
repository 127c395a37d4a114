"""Tests read from a campaign's folder, or of a bundled campaign, whatever their kind."""

from __future__ import annotations

from pathlib import Path

from pipeclamp_identification.campaign.bundled import campaign_folder
from pipeclamp_identification.campaign.description import read_description
from pipeclamp_identification.campaign.reading import campaign_of
from pipeclamp_identification.campaign.runs_table import read_runs_table
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_identification.workflow.tests import Tests


def read_tests(campaign: Path, strict: bool = False) -> Tests:
    """Read tests: records, or metrics where there are no records.

    Args:
        campaign: the folder, or the name of a bundled campaign.
        strict: a run that can't be used is an error.

    Raises:
        UserError: a file is missing or not as expected; no run can be used; or, with `strict`, one can't.
    """
    folder = campaign_folder(campaign)
    description = read_description(folder)
    table = read_runs_table(folder, description)
    if table.without_records:
        # Tests with records start without.
        from pipeclamp_identification.metrics_only.campaign import metric_campaign_of
        from pipeclamp_identification.workflow.on_metrics import MetricTests

        return MetricTests(metric_campaign_of(folder, description, table, strict))
    return RecordTests(campaign_of(folder, description, table, strict))
