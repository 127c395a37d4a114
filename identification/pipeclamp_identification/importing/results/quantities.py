"""What columns of results mean: frequency, amplitudes, stiffness, loss angle; by names, symbols and units."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import replace

from pipeclamp_identification.importing.channels.naming import SETTINGS_CALLED, rank, unit_of, words_of
from pipeclamp_identification.importing.raw import Channel
from pipeclamp_identification.units.stated import Conversion, conversion, in_its_case, unit_in_name
from pipeclamp_models.base.errors import UserError

TARGETS: Mapping[str, str] = {
    "frequency": "Hz", "amplitude": "mm", "force_amplitude": "N", "storage_stiffness": "N/mm",
    "loss_stiffness": "N/mm", "dynamic_stiffness": "N/mm", "loss_angle": "rad", "loss_factor": "",
    "damping_ratio": "", "dissipated_energy": "J", "temperature": "degC", "size": "mm",
    "area": "mm^2", "damping_coefficient": "N*s/mm",
}  # fmt: skip
"""Quantities of a result, and their units here; a loss factor and a damping ratio have none."""
STIFFNESSES = ("storage_stiffness", "loss_stiffness", "dynamic_stiffness")
LOSSES = ("loss_angle", "loss_factor", "damping_ratio", "dissipated_energy", "damping_coefficient")
SHARES_OF_ONE = ("loss_factor", "damping_ratio")
RADIAN = 1 / (2 * math.pi)
TURNS = {"rad": RADIAN, "rpm": 1 / 60, "1/min": 1 / 60, "min-1": 1 / 60}
"""Hz in what a frequency's unit begins with, where that counts angles or minutes."""
PER_SECOND = re.compile(r"1?/s(?:ec)?|s(?:ec)?\^?\(?-1\)?")
"""A frequency's unit that leaves open whether cycles or radians are counted: the name tells."""
ANGULAR = frozenset(
    ("angular", "omega", "w", "kreisfrequenz", "winkelfrequenz", "pulsation", "pulsazione", "pulsacion")
)
"""Words of a frequency that counts radians."""
SAME_LETTERS = str.maketrans({"’": "'", "′": "'", "`": "'", "´": "'", "″": '"', "”": '"', "“": '"', "δ": "delta"})
LOSS_ANGLES = frozenset(("phase", "delta", "verlustwinkel", "phasenwinkel", "dephasage", "sfasamento", "desfase"))
LOSS_FACTORS = frozenset(("tan", "tand", "tandelta", "verlustfaktor"))
DAMPING_RATIOS = frozenset(("heq", "zetaeq", "xieq", "daempfungsgrad", "daempfungsmass"))
DAMPING = frozenset(("damping", "amortissement", "smorzamento", "amortiguamiento"))
COEFFICIENTS = DAMPING | frozenset(("c", "ceq", "ceff", "dashpot", "daempfung", "daempfungskonstante"))
"""Words and symbols of a damping coefficient, beside a unit of one: the loss stiffness over the angular frequency."""
WHOLE_BEYOND_DOUBT = frozenset(("dynamic", "complex", "kdyn", "cdyn", "dyn", "dynamische", "komplexe", "absolute"))
"""Words of a stiffness that is the ratio of the amplitudes, also beside a damping coefficient."""
RATIO = frozenset(("ratio", "equivalent", "effective", "taux", "rapporto", "relacion", "critical"))
"""Words that beside one of damping say that it is a share of the critical one."""
DISSIPATED = frozenset(
    (
        "dissipated",
        "dissipation",
        "dissipierte",
        "dissipee",
        "dissipata",
        "disipada",
        "dw",
        "verlustarbeit",
        "hysteresis",
    )
)
"""Words of the energy that a cycle loses, beside a unit of energy."""
PRIMED = re.compile(r"[egk]_?(p|prime)(p|prime)?|[egk]_?(double|dbl|d)_?(prime)")
"""A modulus or stiffness whose strokes are spelt: Gp, Gpp, E_prime, G_double_prime."""
STORED = frozenset(("storage", "stor", "speicher", "speichersteifigkeit", "speichermodul", "elastic", "conservation"))
LOST = frozenset(("loss", "verlust", "verluststeifigkeit", "verlustmodul", "viscous", "perte"))
WHOLE = frozenset(
    (
        "dynamic",
        "complex",
        "stiffness",
        "kdyn",
        "cdyn",
        "keff",
        "keq",
        "dyn",
        "dynamische",
        "steifigkeit",
        "komplexe",
        "raideur",
    )
)
STATIC = frozenset(
    (
        *("static", "statisch", "statische", "preload", "vorlast", "offset", "mean", "mittel", "mittelwert", "command"),
        *("setpoint", "soll", "sollwert", "target", "drift", "position", "gap", "stress", "strain"),
    )
)
"""Words of what isn't the amplitude of a sine."""
STRAINS = frozenset(("strain", "dehnung", "scherung", "deformation", "deformazione", "deformacion", "gamma"))
ANGLES = frozenset(("angle", "winkel", "twist", "rotation", "torsion"))
NO_AMPLITUDES = frozenset(
    ("rate", "static", "statisch", "statische", "preload", "offset", "mean", "constant", "command")
)
"""Words of a strain that isn't the amplitude of a sine either."""
UNITLESS = ("%", "-", "1", "")
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
    if unit in UNITLESS and (DAMPING_RATIOS & words or (DAMPING & words and RATIO & words) or name in ("ζ", "ξ")):
        return "damping_ratio"
    if fits("loss_angle", unit) and (LOSS_ANGLES & words or {"loss", "angle"} <= words):
        return "loss_angle"
    if fits("damping_coefficient", unit):
        return "damping_coefficient" if words & COEFFICIENTS else ""
    if fits("dissipated_energy", unit):
        return "dissipated_energy" if words & (DISSIPATED | {"loss"}) else ""
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


def is_k(channel: Channel) -> bool:
    """Tell whether a channel is called K and no more, in a unit of stiffness: what stands beside tells of which."""
    return _plain(channel) == "k" and fits("storage_stiffness", unit_of(channel))


def is_in_phase(channel: Channel) -> bool:
    """Tell whether a stiffness beside a damping coefficient is that of F = K x + C v: what isn't called dynamic is."""
    name = _plain(channel)
    return not WHOLE_BEYOND_DOUBT & set(words_of(name)) and "*" not in name


def fits(quantity: str, unit: str) -> bool:
    """Tell whether a unit is one of a quantity of results."""
    return bool(unit) and turned(quantity, unit) is not None


def turned(quantity: str, unit: str, name: str = "") -> Conversion | None:
    """Give what turns numbers of a quantity into its unit here; None where the unit is one of something else.

    Args:
        quantity: of a result.
        unit: as stated; "12.5 N/mm" where 1 stands for that.
        name: of the channel, which may say that amplitudes are from peak to peak, or effective values, and that what
            is counted in a second are radians.
    """
    unit = in_its_case(unit)
    if quantity == "frequency":
        if PER_SECOND.fullmatch(unicodedata.normalize("NFKC", unit).replace("\u2212", "-").replace(" ", "").casefold()):
            return Conversion(RADIAN if is_angular(name) else 1.0)
        begins = next((one for one in TURNS if unit.replace(" ", "").startswith(one)), None)
        return Conversion(TURNS[begins]) if begins else _turned(quantity, unit, "Hz")
    if quantity in SHARES_OF_ONE:
        return Conversion(0.01 if unit == "%" else 1.0)
    found = _turned("stiffness" if quantity in STIFFNESSES else quantity, unit, TARGETS[quantity])
    if found is None or quantity not in AMPLITUDES:
        return found
    return Conversion(found.factor * amplitude_share(name), found.offset)


def is_angular(name: str) -> bool:
    """Tell whether a frequency of this name counts radians: ω, "w", "Angular frequency"."""
    return not ANGULAR.isdisjoint(words_of(name)) or "ω" in name.casefold()


def is_called_modulus(channel: Channel) -> bool:
    """Tell whether a channel's name alone says that it is a modulus of the material: "Storage Modulus", "E'"."""
    name = _plain(channel)
    return any(word.startswith("modul") or word.endswith("modul") for word in words_of(name)) or bool(
        re.match(r"[eg]['\"*]", name)
    )


def is_strain(channel: Channel) -> bool:
    """Tell whether a channel is a strain, or an angle of deformation: an amplitude that the part's size turns to mm."""
    name, unit = _plain(channel), unit_of(channel)
    words = set(words_of(name))
    if fits("loss_angle", unit) and not LOSS_ANGLES & words:
        return rank("displacement", replace(channel, name=name, unit="mm")) > 2 or not words.isdisjoint(ANGLES)
    return unit in UNITLESS and not STRAINS.isdisjoint(words) and not words & NO_AMPLITUDES


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
    called = {*SETTINGS_CALLED["frequency"], "f", *ANGULAR} - {"angular"}
    return bool(words & called) and not words & {"sample", "sampling"}


def _stiffness_of(name: str, words: set[str]) -> str:
    """Give which stiffness, or modulus, a name means: K' and K'' are the storage and the loss of it."""
    symbol = name.split()[0] if name.split() else ""
    if spelt := PRIMED.fullmatch(symbol):
        return "loss_stiffness" if spelt[2] or spelt[4] else "storage_stiffness"
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
