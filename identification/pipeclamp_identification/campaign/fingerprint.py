"""A campaign's fingerprint: from which bytes its tests were read."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from pipeclamp_identification.campaign import description, runs_table

TABLES = (description.FILE_NAME, runs_table.FILE_NAME)


@dataclass(frozen=True)
class Digests:
    """SHA-256 of a campaign's files, by their names: of its tables, and of its records."""

    tables: Mapping[str, str] = field(default_factory=dict)
    records: Mapping[str, str] = field(default_factory=dict)

    def of(self, records: Collection[str]) -> Digests:
        """Give those of the tables and of some of the records."""
        return Digests(self.tables, {name: digest for name, digest in self.records.items() if name in records})

    @property
    def fingerprint(self) -> str:
        """The SHA-256 over names and digests of all of them."""
        named = [*self.tables.items(), *sorted(self.records.items())]
        return "sha256:" + hashlib.sha256("".join(f"{name}\0{digest}\n" for name, digest in named).encode()).hexdigest()


def digests_of(folder: Path, records: Mapping[str, str]) -> Digests:
    """Give the digests of a campaign's files: of those of its records, its tables in its folder are read."""
    tables = {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in TABLES}
    return Digests(tables, records)
