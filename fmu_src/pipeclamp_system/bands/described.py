"""What isn't known of the clamps of a described system."""

from __future__ import annotations

from pathlib import Path

from pipeclamp_system.bands.quantities import Unknown, unknown_of_clamps
from pipeclamp_system.bands.varied import VariedLaw, refuse_silent, varied
from pipeclamp_system.cosim.building import law_in
from pipeclamp_system.description.system import SystemDescription


def laws_of(description: SystemDescription, folder: Path) -> dict[str, VariedLaw]:
    """Give the laws of a system's clamps by their names there, each with what isn't known of it.

    Raises:
        UserError: a law can't be read.
    """
    named = dict.fromkeys(clamp.law for clamp in description.clamps if clamp.law is not None)
    return {name: varied(law_in(folder, name)) for name in named}


def refuse_unknown(description: SystemDescription, folder: Path, where: str) -> None:
    """Refuse a system none of whose laws tells how sure it is; `where` is named in the error.

    Raises:
        UserError: none does, or one can't be read.
    """
    refuse_silent(laws_of(description, folder).values(), where)


def unknown_of(description: SystemDescription, folder: Path) -> Unknown:
    """Give what isn't known of a system's clamps, each of which has a law, in steady states.

    Raises:
        UserError: a law can't be read.
    """
    known = laws_of(description, folder)
    names = [clamp.at for clamp in description.clamps]
    return unknown_of_clamps([known[str(clamp.law)] for clamp in description.clamps], names, solved=True)
