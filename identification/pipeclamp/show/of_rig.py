"""What of a law is its rig's, and so stays out of its FMU."""

from __future__ import annotations

from pipeclamp_models.base.digits import plain
from pipeclamp_models.base.units import unit_shown
from pipeclamp_models.law.file import LawFile, structure_of


def of_rig_words(file: LawFile) -> str:
    """Say which effects of a law are its rig's, so that its FMU hasn't got them; "" where there are none."""
    effects = [effect for effect in structure_of(file).all_effects() if effect.part == "rig"]
    if not effects:
        return ""
    told = []
    for effect in effects:
        entries = [(one.name, file.coefficients[one.name]) for one in effect.parameters]
        values = ", ".join(f"{name} = {plain(each.value, 3)} {unit_shown(each.unit)}" for name, each in entries)
        told.append(f"{effect.name} ({values})")
    words = f"of the rig, and so not in the FMU: {', '.join(told)}"
    if any(effect.name == "offset" for effect in effects):
        words += (
            ". Where this force is the clamp's own, as a preload's or a gas's is: \"Add an effect of your own\" has a "
            "declaration that stays in the FMU"
        )
    return words
