"""What stands behind a clamp's law, as its FMU tells it: to importers, to machines, to people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pipeclamp_fmu.contents.credibility import EVIDENCE, credibility, verdict_of
from pipeclamp_fmu.contents.parameter_sets import ParameterSets, parameter_sets
from pipeclamp_fmu.contents.reference import Related
from pipeclamp_fmu.describe.documentation import DocumentedSection
from pipeclamp_fmu.describe.ssv import MEDIA_TYPE, parameter_set
from pipeclamp_fmu.slaves.clamp import LAW
from pipeclamp_models.law.file import LawFile

RECORD = "credibility.json"


@dataclass(frozen=True)
class Behind:
    """What stands behind a law.

    Attributes:
        sets: of its parameters, the nominal one and the ends of its bands.
        record: the same and more for machines, JSON.
        verdict: of its last diagnosis, in words.
        origins: of its coefficients, in words.
    """

    sets: ParameterSets
    record: bytes
    verdict: str
    origins: str


def what_stands_behind(
    file: LawFile, source: str, values: Mapping[str, float], where: Sequence[float], version: str
) -> Behind:
    """Give what stands behind a law; the first arguments as of `parameter_sets`, the last is this program's version."""
    sets = parameter_sets(file, source, values, where)
    count = Counter(EVIDENCE[entry.state] for entry in file.coefficients.values())
    origins = ", ".join(f"{number} {evidence}" for evidence, number in sorted(count.items(), reverse=True))
    return Behind(sets, credibility(file, sets, f"pipeclamp {version}"), verdict_of(file), origins)


def related(behind: Behind) -> list[Related]:
    """Give the files that go into the FMU."""
    files = []
    for entry in behind.sets.sets:
        values = {f"{LAW}{name}": value for name, value in entry.values.items()}
        what = parameter_set(entry.name, values, entry.meaning)
        files.append(Related(f"{entry.name}.ssv", MEDIA_TYPE, "parameter", entry.meaning, what))
    meaning = "where the law comes from and how sure it is"
    return [*files, Related(RECORD, "application/json", "meta-data", meaning, behind.record)]


def behind_section(behind: Behind) -> DocumentedSection:
    """Give the section of the FMU's page."""
    nominal = behind.sets.sets[0]
    rows = [
        (
            entry.name,
            entry.meaning,
            f"{entry.loss:.4g} ({_change(entry.loss, nominal.loss)})",
            f"{entry.stiffness:.4g} ({_change(entry.stiffness, nominal.stiffness)})",
        )
        for entry in behind.sets.sets
    ]
    return DocumentedSection(
        "How sure it is",
        (
            f"Coefficients: {behind.origins}. Last diagnosis: {behind.verdict}.",
            "Parameter sets (SSV) in extra/org.fmi-standard.fmi-ls-ref, to be applied before initialization: the law, "
            "and the likeliest parameters at which the energy that the clamp dissipates in a cycle, or its stiffness, "
            "lies at an end of its 95% band, in the middle of the range. They hold what the parameters' covariance "
            "and the scatter from run to run tell.",
            *(f"Mind: {caution}." for caution in behind.sets.cautions),
            f"{RECORD} beside them says the same to machines, coefficient by coefficient.",
        ),
        (),
        ("set", "what it is", "dissipated energy, mJ", "stiffness, N/mm"),
        rows,
    )


def _change(value: float, nominal: float) -> str:
    return f"{100 * (value / nominal - 1):+.2g}%" if nominal else "-"
