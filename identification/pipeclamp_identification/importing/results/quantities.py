"""What columns of results mean: frequency, amplitudes, stiffness, loss angle; by names, symbols and units."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping

from pipeclamp_identification.importing.channels.naming import SETTINGS_CALLED, rank, unit_of, words_of
from pipeclamp_identification.importing.raw import Channel
from pipeclamp_identification.units.stated import Conversion, conversion, unit_in_name
from pipeclamp_models.base.errors import UserError

TARGETS: Mapping[str, str] = {
    "frequency": "Hz", "amplitude": "mm", "force_amplitude": "N", "storage_stiffness": "N/mm",
    "loss_stiffness": "N/mm", "dynamic_stiffness": "N/mm", "loss_angle": "rad", "loss_factor": "",
    "temperature": "degC",
}  # fmt: skip
"""Quantities of a result, and their units here; a loss factor has none."""
STIFFNESSES = ("storage_stiffness", "loss_stiffness", "dynamic_stiffness")
LOSSES = ("loss_angle", "loss_factor")
TURNS = {"rad": 1 / (2 * math.pi), "rpm": 1 / 60, "1/min": 1 / 60, "min-1": 1 / 60}
"""Hz in what a frequency's unit begins with, where that counts angles or minutes."""
SAME_LETTERS = str.maketrans({"’": "'", "′": "'", "`": "'", "´": "'", "″": '"', "”": '"', "“": '"', "δ": "delta"})
LOSS_ANGLES = frozenset(("phase", "delta", "verlustwinkel", "phasenwinkel", "dephasage", "sfasamento", "desfase"))
LOSS_FACTORS = frozenset(("tan", "tand", "tandelta", "verlustfaktor"))
STORED = frozenset(("storage", "stor", "speicher", "speichersteifigkeit", "speichermodul", "elastic", "conservation"))
LOST = frozenset(("loss", "verlust", "verluststeifigkeit", "verlustmodul", "viscous", "perte"))
WHOLE = frozenset(
    ("dynamic", "complex", "stiffness", "kdyn", "cdyn", "dyn", "dynamische", "steifigkeit", "komplexe", "raideur")
)
STATIC = frozenset(
    (
        *("static", "statisch", "statische", "preload", "vorlast", "offset", "mean", "mittel", "mittelwert", "command"),
        *("setpoint", "soll", "sollwert", "target", "drift", "position", "gap", "stress", "strain"),
    )
)
"""Words of what isn't the amplitude of a sine."""
AMPLITUDES = {"amplitude": "displacement", "force_amplitude": "force"}
SYMBOLS = {"amplitude": frozenset(("x", "s", "u", "d", "a")), "force_amplitude": frozenset(("f", "p"))}
"""Letters that stand for a displacement's and a force's amplitude beside a unit of it."""
PEAK_TO_PEAK = re.compile(r"\bp\s*-?\s*p\b|\bpk\s*-?\s*pk\b|peak\s*-?\s*to\s*-?\s*peak|double amplitude|doppelampl")
RMS = re.compile(r"\brms\b|\beff\b")


def quantity_of(channel: Channel) -> str:
    """Give the quantity of a result that a channel is by its name and unit, "" for none or something else."""
    name, unit = _plain(channel), unit_of(channel)
    words = set(words_of(name))
    if fits("frequency", unit) and (_is_frequency(words) or "ω" in name):
        return "frequency"
    if LOSS_FACTORS & words or {"loss", "factor"} <= words:
        return "loss_factor"
    if fits("loss_angle", unit) and (LOSS_ANGLES & words or {"loss", "angle"} <= words):
        return "loss_angle"
    if fits("storage_stiffness", unit) or is_modulus(channel):
        return _stiffness_of(name, words)
    if rank("temperature", channel) > 2 or (words == {"ts"} and fits("temperature", unit)):
        return "temperature"
    for quantity, measured in AMPLITUDES.items():
        if fits(quantity, unit) and not words & STATIC and not name.endswith("0"):
            amplitude = [word for word in words if word.endswith(SETTINGS_CALLED["amplitude"])]
            called = rank(measured, channel) > 2 or amplitude
            if called or SYMBOLS[quantity] & words:
                return quantity
    return ""


def is_modulus(channel: Channel) -> bool:
    """Tell whether a channel is in a unit of stress: a modulus of the material, no stiffness of the part."""
    return _turned("modulus", unit_of(channel), "Pa") is not None


def fits(quantity: str, unit: str) -> bool:
    """Tell whether a unit is one of a quantity of results."""
    return bool(unit) and turned(quantity, unit) is not None


def turned(quantity: str, unit: str, name: str = "") -> Conversion | None:
    """Give what turns numbers of a quantity into its unit here; None where the unit is one of something else.

    Args:
        quantity: of a result.
        unit: as stated; "12.5 N/mm" where 1 stands for that.
        name: of the channel, which may say that amplitudes are from peak to peak, or effective values.
    """
    if quantity == "frequency":
        begins = next((one for one in TURNS if unit.replace(" ", "").startswith(one)), None)
        return Conversion(TURNS[begins]) if begins else _turned(quantity, unit, "Hz")
    if quantity == "loss_factor":
        return Conversion(0.01 if unit == "%" else 1.0)
    found = _turned("stiffness" if quantity in STIFFNESSES else quantity, unit, TARGETS[quantity])
    if found is None or quantity not in AMPLITUDES:
        return found
    return Conversion(found.factor * amplitude_share(name), found.offset)


def amplitude_share(name: str) -> float:
    """Give the amplitude of a sine that a channel of this name states 1 of."""
    plain = unicodedata.normalize("NFKC", name).casefold()
    if PEAK_TO_PEAK.search(plain):
        return 0.5
    return math.sqrt(2.0) if RMS.search(plain) else 1.0


def _turned(quantity: str, unit: str, target: str) -> Conversion | None:
    try:
        return conversion(quantity, unit, target)
    except UserError:
        return None


def _is_frequency(words: set[str]) -> bool:
    return bool(words & {*SETTINGS_CALLED["frequency"], "f", "omega", "w"}) and not words & {"sample", "sampling"}


def _stiffness_of(name: str, words: set[str]) -> str:
    """Give which stiffness, or modulus, a name means: K' and K'' are the storage and the loss of it."""
    symbol = name.split()[0] if name.split() else ""
    if symbol.endswith(('"', "''")) or words & LOST:
        return "loss_stiffness"
    if symbol.endswith("'") or words & STORED:
        return "storage_stiffness"
    if symbol.endswith("*") or (words & WHOLE and not words & STATIC):
        return "dynamic_stiffness"
    return ""


def _plain(channel: Channel) -> str:
    name = channel.name if channel.unit else unit_in_name(channel.name)[0]
    return unicodedata.normalize("NFKC", name.translate(SAME_LETTERS)).casefold().strip()
