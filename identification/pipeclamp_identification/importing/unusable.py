"""Files that can't serve: which, why, and how to go on without them; all are told in one message."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_models.base.errors import UserError

OPTION = "--skip-unusable"
MOST_TOLD = 30
"""Files that a message lists."""
ALL_ALIKE = 20
"""So many files in a row that all lack a channel, and none before them that doesn't, are no strays."""


class UnusableFileError(UserError):
    """A file that can't serve, though others of the same import may.

    Attributes:
        place: the file, or a table in it.
        why: it can't serve, in one line.
        remedy: what else to do, for the file alone.
        is_damaged: whether it can't be read, so that nothing that is stated of channels would help.
    """

    def __init__(self, place: str, why: str, remedy: str = "", *, is_damaged: bool = False) -> None:
        super().__init__(f"{place}: {why}{remedy}")
        self.place, self.why, self.remedy, self.is_damaged = place, why, remedy, is_damaged

    def __reduce__(self) -> tuple[Callable[..., UnusableFileError], tuple[str, str, str, bool]]:
        """Let it come out of another process."""
        return _again, (self.place, self.why, self.remedy, self.is_damaged)


def _again(place: str, why: str, remedy: str, is_damaged: bool) -> UnusableFileError:
    return UnusableFileError(place, why, remedy, is_damaged=is_damaged)


class ResultsFileError(UnusableFileError):
    """A file that holds results, a row a test: alone it is no record, and among its like a campaign of metrics."""

    def __reduce__(self) -> tuple[Callable[..., UnusableFileError], tuple[str, str, str, bool]]:
        """Let it come out of another process."""
        return _results_again, (self.place, self.why, self.remedy, self.is_damaged)


def _results_again(place: str, why: str, remedy: str, is_damaged: bool) -> ResultsFileError:
    return ResultsFileError(place, why, remedy, is_damaged=is_damaged)


@dataclass(frozen=True)
class UnusableFiles:
    """All files of an import that can't serve.

    Attributes:
        errors: of each.
        files: of the import in all.
    """

    errors: Mapping[Path, UnusableFileError]
    files: int

    @property
    def others(self) -> int:
        """Files that can."""
        return self.files - len(self.errors)

    def lines(self) -> list[str]:
        """Say which, and why."""
        lines = [self._line(path) for path in [*self.errors][:MOST_TOLD]]
        more = len(self.errors) - len(lines)
        return [*lines, *([f"and {more} more"] if more else [])]

    def _line(self, path: Path) -> str:
        """Say what is wrong with a file, by its name without folders, which are long."""
        error = self.errors[path]
        return f"{file_name(path)}{error.place.removeprefix(str(path))}: {error.why}"

    def heading(self) -> str:
        """Say how many."""
        return f"{len(self.errors)} of {self.files} files can't be used"

    def refusal(self) -> UserError:
        """Give the one message that tells all of them, and what to do."""
        first = foremost([*self.errors.values()])
        if self.files == 1 or (not self.others and isinstance(first, ResultsFileError)):
            return first
        lines = [f"{self.heading()}; nothing was written", *self.lines()]
        if self.others:
            others = "the other file" if self.others == 1 else f"the other {self.others}"
            lines.append(f"to leave them out and import {others}: {OPTION}")
        elif lacking := [error for error in self.errors.values() if not error.is_damaged]:
            # where none serves, what is open of the channels is the way on
            damaged = [path for path, error in self.errors.items() if error.is_damaged]
            lines = [str(lacking[0]), *map(self._line, damaged[:MOST_TOLD])]
        return UserError("\n  ".join(lines))


def foremost(errors: Sequence[UnusableFileError]) -> UnusableFileError:
    """Give the error that counts where no file serves: that of results, which are imported by themselves."""
    return next((error for error in errors if isinstance(error, ResultsFileError)), errors[0])


def are_no_strays(first: Sequence[UnusableFileError]) -> bool:
    """Tell whether the first files all lack a channel: then which channel is what has to be stated."""
    return len(first) >= ALL_ALIKE and not any(one.is_damaged for one in first)


def listed_why(why: Sequence[tuple[str, str]]) -> list[str]:
    """Say which files were left out, and why.

    Args:
        why: name of each file, and the reason.
    """
    lines = [f"{file}: left out, for it can't be used: {reason}" for file, reason in why[:MOST_TOLD]]
    more = len(why) - len(lines)
    return [*lines, *([f"{more} more files were left out; campaign.toml names all"] if more else [])]
