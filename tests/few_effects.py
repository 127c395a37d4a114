"""A catalogue of few effects: what a diagnosis makes of those that rival shows without asking all the others."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from pipeclamp_identification.diagnosis import screen
from pipeclamp_models.law.catalogue import entries


@contextmanager
def few_effects(*names: str) -> Iterator[None]:
    """Let diagnoses ask these effects of the catalogue alone, and those that tests declare."""
    few = {name: entries()[name] for name in names}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(screen, "entries", lambda: few)
        yield
