"""The tests on the bench: read once, with what laws give on them, so that a click computes one loop and no more."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pipeclamp_identification.comparison.compare import Comparison, compare
from pipeclamp_identification.fitting.misfit import RunMisfit, misfits
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.workflow.on_metrics import MetricTests
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_identification.workflow.reading import read_tests
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Law

MOST_KEPT = 12
"""Laws whose comparisons are kept."""


@dataclass(frozen=True)
class OneRun:
    """One run by itself: what a click looks at.

    Attributes:
        row: its place among the runs.
        tests: the tests with this run alone.
        loops: its loop, one row.
    """

    row: int
    tests: RecordTests
    loops: Loops

    def misfit(self, law: Law) -> RunMisfit:
        """Give how a law fits it, over its samples."""
        return misfits(law, self.tests.campaign, self.loops)[0]


class Bench:
    """A campaign's tests, and laws held against them.

    Attributes:
        tests: without runs of free motion.
        loops: one row a run; computed at once, for several threads ask for them.
        rows: the place of each run, by its name.
    """

    def __init__(self, tests: RecordTests) -> None:
        """Take the tests; runs of free motion stay aside."""
        self.tests = tests.of_sines()
        self.loops: Loops = self.tests.loops
        self.rows: Mapping[str, int] = {name: row for row, name in enumerate(self.loops.run)}
        self._held: OrderedDict[str, Comparison] = OrderedDict()
        self._lock = threading.RLock()

    def held(self, file: LawFile) -> Comparison:
        """Give a law held against all runs; what was held lately is remembered."""
        key = file.model_dump_json()
        with self._lock:
            found = self._held.pop(key, None) or compare(file, self.tests.campaign, self.loops)
            _ = found.sums  # kept with it
            self._held[key] = found
            if len(self._held) > MOST_KEPT:
                self._held.popitem(last=False)
            return found

    def run(self, name: str) -> OneRun:
        """Give one run.

        Raises:
            UserError: there is none of that name.
        """
        row = self.rows.get(name)
        if row is None:
            raise UserError(f"run {name!r}: not in this campaign; expected one of its {len(self.rows)} runs")
        campaign = self.tests.campaign
        alone = RecordTests(campaign.of_runs((campaign.runs[row],)))
        return OneRun(row, alone, replace(self.loops, rows=(self.loops.rows[row],)))


def read_bench(campaign: str) -> Bench | MetricTests:
    """Read a campaign; of metrics without records there are no loops to be clicked at.

    Raises:
        UserError: it can't be read.
    """
    tests = read_tests(Path(campaign))
    if isinstance(tests, RecordTests):
        return Bench(tests)
    assert isinstance(tests, MetricTests)
    return tests


def changed(law: Law, values: Mapping[str, float]) -> Law:
    """Give a law with other values for some of its parameters.

    Raises:
        UserError: it has no such parameter.
    """
    if foreign := set(values) - set(law.values):
        raise UserError(f"got {sorted(foreign)}; expected parameters of the law: {', '.join(sorted(law.values))}")
    return replace(law, values={**law.values, **values})


def with_candidate(file: LawFile, effects: Sequence[str], values: Mapping[str, float]) -> Law:
    """Give a law with candidates' effects, at the values that a diagnosis fitted.

    Raises:
        UserError: the values aren't those of its equations.
    """
    law = law_of(file)
    structure = replace(law.structure, effects=tuple(effects))
    if set(structure.equations.names) != set(values):
        raise UserError(f"the law has changed since it was diagnosed with {', '.join(effects)}; diagnose again")
    return Law(structure, dict(values), law.v_r, law.y_r)
