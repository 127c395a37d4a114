"""What comes next, where something may have to be done before the command can be run."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class NextStep:
    """What comes next.

    Attributes:
        line: the shell line to run.
        first: what has to be done before it, in words; empty where nothing has.
    """

    line: str
    first: str = ""

    def once(self, first: str) -> NextStep:
        """Give it with something that has to be done before all else, in words."""
        return replace(self, first=f"{first}, {self.first}" if self.first else first)

    def words(self) -> str:
        """Say it."""
        return f"Next, {self.first}: {self.line}" if self.first else f"Next: {self.line}"

    def before(self) -> list[str]:
        """Say what has to be done before it, where the line stands below."""
        return [f"Next, {self.first}, run the command below."] if self.first else []
