"""The tasks of jobs: each does what a command does, and writes what the command would."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeclamp.now import now
from pipeclamp.studio.project import DIAGNOSIS, DRIVE, SHOWN
from pipeclamp_identification.workflow.reading import read_tests
from pipeclamp_identification.workflow.tests import Diagnosed, Tests
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.base.processes import Workers, spare_cores
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.law.file import LawFile, NamedKind, Provenance, law_text, read_law
from pipeclamp_models.law.law import Structure

if TYPE_CHECKING:
    from pipeclamp_identification.diagnosis.further_test.limits import Limits
    from pipeclamp_identification.workflow.climb import Rung


def identify(tell: Progress, *, campaign: str, law: str, base: str, command: str) -> dict[str, Any]:
    """Fit a law to all runs and write it."""
    tests = _tests(tell, campaign)
    found = tests.identify(Structure(base), progress=tell)
    return _written(found.file(name=tests.name, provenance=Provenance(command, now())), law)


def add(
    tell: Progress, *, campaign: str, of: str, effect: str, kind: NamedKind | None, law: str, command: str
) -> dict[str, Any]:
    """Add an effect to a law, or several with commas between them, refit everything and write it."""
    from pipeclamp_identification.workflow.change import add_effects

    tests = _tests(tell, campaign)
    steps = add_effects(
        read_law(Path(of)), effect.split(","), tests, provenance=Provenance(command, now()), kind=kind, progress=tell
    )
    return _written(steps[-1].after, law)


def refit(tell: Progress, *, campaign: str, of: str, law: str, command: str) -> dict[str, Any]:
    """Fit a law with its effects to all tests anew and write it."""
    from pipeclamp_identification.workflow.change import refit as refitted

    tests = _tests(tell, campaign)
    done = refitted(read_law(Path(of)), tests, provenance=Provenance(command, now()), progress=tell)
    return _written(done.after, law)


def diagnose(tell: Progress, *, campaign: str, law: str, limits: str) -> dict[str, Any]:
    """Find what a law lacks, and write it beside the law."""
    tests, file = _tests(tell, campaign), read_law(Path(law))
    found = tests.diagnose(file, limits=_reach(limits), workers=Workers(spare_cores(), tell))
    tell("next test")
    _write_diagnosis(found, file, campaign, law, ())
    return {"verdict": found.verdict}


def climb(tell: Progress, *, campaign: str, of: str, law: str, limits: str, command: str) -> dict[str, Any]:
    """Add what a law lacks, again and again; the best law so far is always on disk, for whoever stops it.

    Where nothing is added the diagnosis is written beside the law as it is.
    """
    from pipeclamp_identification.workflow.auto import add_until_settled
    from pipeclamp_identification.workflow.so_far import SoFar

    tests, file = _tests(tell, campaign), read_law(Path(of))

    def doing(words: str) -> None:
        tell("\n".join(filter(None, (so_far.steps, words))))

    so_far = SoFar(doing, keep=lambda best: write_whole(Path(law), law_text(best)))
    settled = add_until_settled(
        file, tests, command=command, limits=_reach(limits), workers=Workers(spare_cores(), so_far.doing),
        climbed=so_far.come,
    )  # fmt: skip
    if not settled.ladder:
        _write_diagnosis(settled.found, file, campaign, of, ())
        return {"verdict": settled.found.verdict}
    ended = settled.with_diagnosis(tests.name).model_copy(update={"date": now()})
    _write_diagnosis(settled.found, ended, campaign, law, settled.ladder)
    return _written(ended, law)


def _reach(limits: str) -> Limits | None:
    """Give what the rig can do; None where nothing is stated."""
    from pipeclamp_identification.diagnosis.further_test.limits import parse_limits

    return parse_limits(limits) if limits else None


def _write_diagnosis(found: Diagnosed, file: LawFile, campaign: str, law: str, ladder: tuple[Rung, ...]) -> None:
    """Write, beside a law, the answer, what the studio shows of it, and the next test's drive signal."""
    from pipeclamp.show.diagnosis_views import diagnosis_view
    from pipeclamp.studio.diagnosis_shown import shown_diagnosis
    from pipeclamp_identification.campaign.drive import drive_content
    from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
    from pipeclamp_identification.workflow.next_command import next_command

    assert isinstance(found, RecordDiagnosed)
    answer, shown, drive = (Path(law).with_suffix(suffix) for suffix in (DIAGNOSIS, SHOWN, DRIVE))
    if found.proposal:
        write_whole(drive, drive_content(found.proposal.plan.signal(), drive))
    write_whole(answer, diagnosis_view(found, ladder, next_command(found, law, campaign)).answer.json_text())
    write_whole(shown, shown_diagnosis(found, file).json_text())


def build(tell: Progress, *, law: str, fmu: str) -> dict[str, Any]:
    """Build the law's FMU, of the kind that `build-fmu` makes unasked."""
    from pipeclamp.api.fmu import build_fmu
    from pipeclamp_fmu.native.compiler import kind_unasked

    kind = kind_unasked()
    tell(f"build a {kind} FMU")
    build_fmu(law, fmu, kind, track=True)
    return {"file": Path(fmu).name}


def report(tell: Progress, *, campaign: str, law: str, page: str) -> dict[str, Any]:
    """Write the page of a law held against the tests."""
    from pipeclamp.api.comparison import compare

    tell("compare, and draw")
    compare(law, campaign).report(page)
    return {"file": Path(page).name}


def look_into(tell: Progress, *, files: list[str], folder: str, **stated: Any) -> dict[str, Any]:
    """Say what files would become, and write nothing; `stated` are options of an import."""
    return _imported(tell, files, folder, dry_run=True, **stated)


def import_into(tell: Progress, *, files: list[str], folder: str, **stated: Any) -> dict[str, Any]:
    """Make a campaign of files; `stated` are options of an import."""
    return _imported(tell, files, folder, dry_run=False, **stated)


def _imported(tell: Progress, files: list[str], folder: str, **stated: Any) -> dict[str, Any]:
    from pipeclamp.api.importing import import_files
    from pipeclamp.pages.imported import first_look
    from pipeclamp.show.table import cell

    found = import_files(files, folder, progress=tell, **stated)
    view = found.view()
    tables = [
        {"caption": table.caption, "header": list(table.header), "rows": [[cell(v) for v in row] for row in table.rows]}
        for table in view.tables
    ]
    return {
        "lines": [*view.lines, *found.notes],
        "tables": tables,
        "loops": first_look(found.found),
        "written": found.written,
        "name": Path(folder).name,
    }


def _tests(tell: Progress, campaign: str) -> Tests:
    tell("reading the tests")
    return read_tests(Path(campaign)).of_sines()


def _written(file: LawFile, law: str) -> dict[str, Any]:
    write_whole(Path(law), law_text(file))
    return {"law": Path(law).stem}
