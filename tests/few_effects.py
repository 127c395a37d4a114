"""A catalogue of few effects: what is made of those that rival shows without asking all the others."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from pipeclamp_identification.diagnosis import screen
from pipeclamp_identification.planning import scene
from pipeclamp_models.law.catalogue import entries, listed


@contextmanager
def few_effects(*names: str) -> Iterator[None]:
    """Let diagnoses and plans ask these effects of the catalogue alone, and those that are declared."""
    few = {name: entries()[name] for name in names}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(screen, "entries", lambda: few)
        patch.setattr(scene, "listed", lambda: [effect for effect in listed() if effect.id in few])
        yield
