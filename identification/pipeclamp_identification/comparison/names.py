"""Names that tell laws apart where several stand beside each other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pipeclamp_models.law.file import LawFile


def named_apart(files: Sequence[LawFile], origins: Sequence[str]) -> list[LawFile]:
    """Give laws that are compared, those of one name with the file beside it that each came from.

    Args:
        files: the laws.
        origins: the file, or the bundled name, of each.
    """
    names = [file.name for file in files]
    alike = [names.count(name) > 1 and len(set(origins)) > 1 for name in names]
    return [
        file.model_copy(update={"name": f"{file.name} ({origin})"}) if doubtful else file
        for file, origin, doubtful in zip(files, origins, alike, strict=True)
    ]


def labels_of(files: Iterable[LawFile]) -> tuple[str, ...]:
    """Give names that tell laws apart: their own, with the effects where another has that name already."""
    labels: list[str] = []
    for file in files:
        label = file.name
        if label in labels:
            label = f"{file.name}: {', '.join(file.effects) or file.base}"
        number = 2
        while label in labels:
            label, number = f"{file.name} ({number})", number + 1
        labels.append(label)
    return tuple(labels)
