"""The search for a term that no catalogue has: what its job does, and what is shown of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from pipeclamp.now import now
from pipeclamp.studio.diagnosis_shown import stamp
from pipeclamp.studio.project import DISCOVERY_SHOWN, Project
from pipeclamp_identification.workflow.reading import read_tests
from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.base.processes import Workers, spare_cores
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.law.file import LawFile, law_text, read_law


class DiscoveryShown(AnswerModel):
    """A discovery as it is shown."""

    law_command: str = Field(description="the command that made the law which was asked, and its date")
    proposed: bool
    words: tuple[str, ...]
    guards: tuple[tuple[str, bool, str], ...] = Field(description="what was asked of the best term, whether it passed")
    law: str | None = Field(description="name of the law with the term, or with the effect in its place")


def discover(
    tell: Progress, *, campaign: str, of: str, law: str, term: str, answer: str, shown: str, command: str
) -> dict[str, Any]:
    """Search a term that a law lacks; write it, the law with it, the answer, and what the studio shows of it."""
    from pipeclamp.show.discovery import discovery_words
    from pipeclamp_identification.discovery.proposal import toml_of
    from pipeclamp_identification.workflow.discover import discover as discovered

    tell("reading the tests")
    tests, file = read_tests(Path(campaign)).of_sines(), read_law(Path(of))
    found = discovered(file, tests, command=command, workers=Workers(spare_cores(), tell))
    if found.declaration is not None:
        write_whole(Path(term), toml_of(found.declaration))
    if found.after is not None:
        write_whole(Path(law), law_text(found.after.model_copy(update={"date": now()})))
    write_whole(Path(answer), found.answer().json_text())
    discovery = DiscoveryShown(
        law_command=stamp(file),
        proposed=found.proposed,
        words=tuple(discovery_words(found)),
        guards=tuple((one.name, one.passed, one.words) for one in found.guards),
        law=Path(law).stem if found.after is not None else None,
    )
    write_whole(Path(shown), discovery.json_text())
    return {"law": discovery.law} if discovery.law else {}


def discovery_in(project: Project, name: str, file: LawFile) -> DiscoveryShown | None:
    """Give what a search found for a law; None where there was none, or another law of that name was asked."""
    path = project.folder / f"{name}{DISCOVERY_SHOWN}"
    try:
        discovery = DiscoveryShown.model_validate_json(path.read_text(encoding="utf-8"))
    except (OSError, ValidationError, UnicodeDecodeError):
        return None
    return discovery if discovery.law_command == stamp(file) else None
