"""Units that a name states, "Load [kN]" or "Weg/mm", and what turns them into ours; by pint."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from pipeclamp_models.base.digits import rounded_to
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.units import CELSIUS, unit_shown

if TYPE_CHECKING:
    import pint

Quantity = str
"""time, displacement, force or temperature; any other word has no unit of its own here."""

OURS: Mapping[Quantity, str] = {"time": "s", "displacement": "mm", "force": "N", "temperature": "degC"}
QUANTITY_OF: Mapping[str, Quantity] = {f"{quantity}_{unit}": quantity for quantity, unit in OURS.items()} | {
    "temperature_C": "temperature"
}
"""What each column of a record holds."""
SETTINGS: Mapping[str, str] = {"amplitude": "mm", "frequency": "Hz", "temperature": "degC", "density": "g/cm^3"}
"""Units in which conditions of a run are stated."""
FURTHER: Mapping[str, str] = {"pressure": "Pa", "current": "A", "voltage": "V", "preload": "N", "torque": "N m"}
"""What else is set in tests of isolators and dampers, with a unit of it."""

SPELLINGS: Mapping[str, str] = {
    "sec": "s", "secs": "s", "sek": "s", "seconds": "s", "sekunden": "s", "msec": "ms", "minutes": "min", "hr": "h",
    "mm": "mm", "millimeter": "mm", "inch": "in", "inches": "in", "zoll": "in", '"': "in", "mil": "thou",
    "mils": "thou", "micron": "um", "microns": "um", "kn": "kN", "newton": "N", "kp": "kgf", "kilopond": "kgf",
    "lbf": "lbf", "lbs": "lbf", "klbf": "kip", "kips": "kip", "tonf": "1000 kgf",
    "celsius": "degC", "deg c": "degC", "deg. c": "degC", "grad c": "degC", "° c": "degC", "degc": "degC",
    "fahrenheit": "degF", "deg f": "degF", "deg. f": "degF", "° f": "degF", "degf": "degF", "kelvin": "K",
    "°c": "degC", "°f": "degF", "°k": "K", "deg k": "K", "degrees c": "degC", "degrees celsius": "degC",
    "oc": "degC", "degree celsius": "degC", "deg celsius": "degC", "grad celsius": "degC", "degrees f": "degF",
    "degrees fahrenheit": "degF", "pound": "lbf", "pounds": "lbf", "pounds-force": "lbf", "pound-force": "lbf",
    "秒": "s", "毫秒": "ms", "毫米": "mm", "牛": "N", "千牛": "kN", "초": "s",
    "с": "s", "сек": "s", "мс": "ms", "мм": "mm", "мкм": "um", "н": "N", "кн": "kN", "кгс": "kgf",
}  # fmt: skip
"""How machines spell units that pint knows by another name; in any case."""
OF_ONE_CASE: Mapping[str, str] = {
    unit.casefold(): unit
    for unit in (
        *("N", "kN", "daN", "kgf", "lb", "lbf", "Hz", "kHz", "Pa", "kPa", "MPa", "GPa", "kJ", "mm", "cm", "m", "um"),
        *("in", "ft", "s", "ms", "us", "rad", "deg"),
    )
}
"""Symbols whose capitals names in small letters lose, and headings in capitals gain: "force_n", "FREQ (HZ)". Of mN and
MN, or mJ and MJ, nobody can tell then; MPa is meant, for no modulus is in mPa."""
ALONE = frozenset(("M", "S", "m", "s"))
"""Of these, symbols of another unit where they stand alone in capitals."""
MEANT: Mapping[Quantity, Mapping[str, str]] = {
    "force": {"kg": "kgf", "g": "gf", "lb": "lbf", "t": "1000 kgf", "to": "1000 kgf", "klb": "kip"},
    "preload": {"kg": "kgf", "lb": "lbf"},
    "stiffness": {"lb/in": "lbf/in", "lbs/in": "lbf/in", "kg/mm": "kgf/mm", "kg/cm": "kgf/cm"},
    "temperature": {"c": "degC", "f": "degF", "k": "K", "°": "degC", "deg": "degC"},
    "time": {"S": "s", "m": "min"},
    "displacement": {"M": "m"},
    "acceleration": {"g": "standard_gravity", "G": "standard_gravity"},
}
"""What a unit of something else means where a force, a temperature, ... is stated in it."""
BARE: Mapping[str, Quantity] = {
    **dict.fromkeys(("s", "sec", "ms", "msec", "us", "µs", "min", "h", "sek"), "time"),
    **dict.fromkeys(("mm", "m", "cm", "um", "µm", "in", "inch", "zoll", "mil", "mils", "ft"), "displacement"),
    **dict.fromkeys(("n", "kn", "mn", "dan", "lbf", "lb", "lbs", "kip", "kips", "kgf", "kp", "kg"), "force"),
    **dict.fromkeys(("c", "k", "f", "degc", "degf", "°c", "°f"), "temperature"),
    **{"с": "time", "сек": "time", "мс": "time", "мм": "displacement", "мкм": "displacement"},
    **dict.fromkeys(("н", "кн", "кгс"), "force"),
}
"""Units that stand at the end of a name without brackets, in lower case, and what they are of."""
OF_OTHERS: Mapping[str, str] = {
    **{unit: unit for unit in ("Hz", "kHz", "1/s", "1/min", "Pa", "kPa", "MPa", "GPa", "rad", "deg", "%")},
    **{unit: unit for unit in ("J", "kJ", "mJ")},
    **dict.fromkeys(("pct", "percent"), "%"),
}
"""Units of something else that stand so, and what they mean; A, V or bar may be a symbol or a word of the name."""
RATIOS = ("mm/s", "mm/s**2", "N/mm", "rad/s")
"""What a unit with a stroke turns into that stands so: "Kraft F/kN" is no capacity over a force."""
RATES: Mapping[Quantity, str] = {"speed": "mm/s", "acceleration": "mm/s**2"}
"""What a displacement is integrated from, the first once, the second twice."""
SAME_FACTOR_SHARE = 2e-3
"""A factor agrees with a unit where it differs by no more than its rounding does: 9.81 for 9.80665 is 3e-4 off."""

DEGREES = str.maketrans("º˚", "°°")
"""What keyboards and programs write for the sign of degrees; the first would become an o."""
BRACKETED = re.compile(r"^(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*$", re.DOTALL)
SLASHED = re.compile(r"^(.*\S)\s*/\s*([^\s/]+)\s*$", re.DOTALL)
TRAILING = re.compile(r"^(.*\S)(?:\s*,\s*|\s+in\s+|[\s_]+)([^\s_,]+)\s*$", re.DOTALL)
RATIO = re.compile(r"^[^\s/]+/[^\s/]+$")
SPELT_RATIO = re.compile(r"^(.*\S)[\s_]+([^\s_,/]+)[\s_]per[\s_]([^\s_,/]+)\s*$", re.DOTALL)
"""A unit with its stroke spelt, behind a name: "stiffness_kN_per_mm"."""
LETTERS = re.compile(r"[A-Za-z]+")
WORD = re.compile(r"[a-z]*(?:met(?:er|re)|newton|second|minute|volt|ampere|pascal|kelvin)s?", re.IGNORECASE)
"""A unit's whole name, whose letters may be capitals, as in a heading; of symbols, and of other words, they tell."""
FORCE_SECONDS = re.compile(r"\b(k?n|lb)f?[ .*·⋅-]?s(?=/)", re.IGNORECASE)
"""The beginning of a damping coefficient's unit, however it is written: "Ns/mm", "N·s/m", "lb-s/in"."""
SQUARED = re.compile(r"(/ ?s)2$")
"""The end of an acceleration's unit whose exponent has lost its sign."""
NUMBERED = re.compile(r"^([-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)\s*(.*)$", re.DOTALL)


@dataclass(frozen=True)
class Conversion:
    """How a number in another unit becomes one in ours: factor * theirs + offset, then integrated so many times."""

    factor: float = 1.0
    offset: float = 0.0
    integrated: int = 0

    def words(self) -> str:
        """Give it as a person writes it."""
        shift = f" {self.offset:+.6g}" if self.offset else ""
        return ", ".join(filter(None, [f"x {self.factor:.6g}{shift}", self.integrated_words]))

    @property
    def integrated_words(self) -> str:
        """How often it is integrated; "" where it isn't."""
        return ("", "integrated", "integrated twice")[self.integrated]


def unit_in_name(name: str) -> tuple[str, str]:
    """Part a column's name into what it names and the unit that it states, "" where it states none.

    "Load [kN]", "Axial Force (kN)", "Weg/mm", "Zeit, s", "LVDT in", "force_N", "speed_mm/s" and "k_kN_per_mm" state
    one; "Load (cell 1)" doesn't.
    """
    text = _normal(name)
    if found := BRACKETED.match(text):
        inside = (found[2] if found[2] is not None else found[3]).strip()
        # "data(1)" is the first of several
        counted = found[2] is None and inside.isdigit()
        return (found[1].strip(), inside) if inside and not counted and is_unit(inside) else (text, "")
    if (found := SPELT_RATIO.match(text)) and _stands_bare(f"{found[2]}/{found[3]}"):
        return found[1].rstrip(" ,"), f"{found[2]}/{found[3]}"
    if (found := TRAILING.match(text)) and _stands_bare(found[2]):
        unit = in_its_case(found[2])
        return found[1].removesuffix(" in").rstrip(" ,"), OF_OTHERS.get(unit, unit)
    if (found := SLASHED.match(text)) and (found[2].casefold() in BARE or is_unit(found[2])):
        return found[1].strip(), found[2]
    return text, ""


def _normal(text: str) -> str:
    """Give a text with one character for each sign, also where a keyboard has but a like one (º, ˚) of degrees."""
    return unicodedata.normalize("NFKC", text.translate(DEGREES)).replace("μ", "µ").strip()


def _stands_bare(unit: str) -> bool:
    """Tell whether what stands at the end of a name, parted from it by a blank, a comma or `_`, surely is a unit."""
    quantity = BARE.get(unit.casefold())
    if quantity and _conversion_to(OURS[quantity], unit, quantity):  # "load_mn" may be in mN or MN
        return True
    if in_its_case(unit) in OF_OTHERS:
        return True
    if not RATIO.match(unit):
        return False
    # by t/s, a mass, nobody means a damping
    damping = FORCE_SECONDS.match(unit) and _conversion_to("N*s/mm", unit, "")
    return bool(damping) or any(_conversion_to(ours, unit, "") for ours in RATIOS)


def is_unit(text: str) -> bool:
    """Tell whether a text is the name of a unit, or a number of them."""
    return any(_conversion_to(unit, text, quantity) for quantity, unit in OURS.items()) or _known(_of_damping(text))


def quantity_of_unit(text: str) -> Quantity | None:
    """Give what is measured in a unit: time, displacement, force or temperature; None for anything else."""
    if (plain := BARE.get(text.strip().casefold())) is not None:
        return plain
    return next((quantity for quantity, unit in OURS.items() if _conversion_to(unit, text, quantity)), None)


def further_quantity(text: str) -> Quantity | None:
    """Give what else than a record's quantities is stated in a unit: a pressure, a current, ...; None for no unit."""
    return next((quantity for quantity, unit in FURTHER.items() if _conversion_to(unit, text, quantity)), None)


def conversion(quantity: Quantity, unit: str, target: str = "") -> Conversion:
    """Give what turns numbers in a unit into ours.

    Args:
        quantity: time, displacement, force or temperature.
        unit: as it was stated; "0.2 kN" where 1 stands for 0.2 kN.
        target: our unit of it, where it isn't that of a record's column.

    Raises:
        UserError: it is no unit of this quantity.
    """
    ours = target or OURS[quantity]
    found = _conversion_to(ours, unit, quantity)
    if found is None:
        lever = f", or what 1 {unit} stands for, by its lever or calibration: [2.5 {unit_shown(ours)}]"
        raise UserError(
            f"{unit!r} is no unit of {quantity}; expected one that turns into {unit_shown(ours)}, such as {_some(ours)}"
            f"{lever if _known(unit) else ''}"
        )
    return found


def conversion_of_rate(unit: str) -> Conversion | None:
    """Give what turns a speed or an acceleration in a unit into mm; None for a unit of neither.

    c is one of temperature here, and not the speed of light.
    """
    if unit.strip().casefold() in BARE:
        return None
    for times, (quantity, ours) in enumerate(RATES.items(), 1):
        if found := _conversion_to(ours, unit, quantity):
            return Conversion(found.factor, integrated=times)
    return None


@cache
def stated_conversion(quantity: Quantity, name: str, factor: float | None) -> Conversion:
    """Give what turns a channel into ours, by the unit in its name and the factor that was stated.

    Args:
        quantity: time, displacement, force or temperature.
        name: of the channel; a unit that it states counts.
        factor: None where none was stated; its sign turns the channel's.

    Raises:
        ValueError: they contradict each other, or the unit is one of something else and no factor turns it.
    """
    _, unit = unit_in_name(name)
    found = _conversion_to(OURS[quantity], unit, quantity) if unit else None
    if found is None:
        # "Force F" names no unit of temperature, but "Force [mm]" one of length
        if unit and factor is None and name.rstrip().endswith(("]", ")")) and unit not in ("-", "1"):
            raise ValueError(
                f"{name!r} is in {unit}, no unit of {quantity}; expected one, or a factor that turns it into "
                f"{OURS[quantity]}"
            )
        return Conversion(1.0 if factor is None else factor)
    if factor is None:
        return found
    if abs(abs(factor) - abs(found.factor)) > SAME_FACTOR_SHARE * abs(found.factor):
        raise ValueError(
            f"{name!r} states {unit}, which turns into {unit_shown(OURS[quantity])} by {found.factor:.6g}; got factor "
            f"{factor:g}; expected that one, or none: the unit in the name counts"
        )
    sign = math.copysign(1.0, factor)
    return Conversion(sign * found.factor, sign * found.offset)


def _some(ours: str) -> str:
    return {"s": "s, ms or min", "mm": "mm, m, um or in", "N": "N, kN, lbf or kgf", "degC": "°C, K or °F"}.get(
        ours, unit_shown(ours)
    )


POWERS = re.compile(r"(?:\*\*|\^)[ \-]*(?:\w{3}|[\w.]+ *(?:\*\*|\^))")
"""Exponents that no unit has, powers of powers: worked out, they are numbers without end."""


@cache
def _conversion_to(ours: str, unit: str, quantity: Quantity) -> Conversion | None:
    """Give the conversion of a unit; None where it is of something else, or none at all."""
    numbered = NUMBERED.match(unit.strip())
    number, text = (float(numbered[1]), numbered[2]) if numbered else (1.0, unit.strip())
    text = _normal(text)
    if not text or not number:
        return None
    meant = MEANT.get(quantity, {})
    spelled = meant.get(text, meant.get(text.casefold(), _spelled(text)))
    if spelled == "K" and ours == "degC":
        return Conversion(number, -CELSIUS)
    # "% s" is a comment's sign before a unit, no hundredth of a second
    if not re.fullmatch(r"[\w°µ^*/.\- ·²³]{1,24}", spelled) or POWERS.search(spelled):
        return None
    # what is plain needs no library of units
    if spelled == ours:
        return Conversion(number)
    try:
        registry = _registry()
        zero = registry.Quantity(0.0, registry.parse_units(spelled)) if ours == "degC" else None
        one = registry.Quantity(1.0, registry.parse_units(spelled)) if ours == "degC" else registry.Quantity(spelled)
        offset = float(zero.to(ours).magnitude) if zero is not None else 0.0
        return Conversion(_rounded(number * (float(one.to(ours).magnitude) - offset)), _rounded(offset))
    except Exception:  # pint raises what its parser's parts raise: of anything that isn't a unit of this kind
        return None


def _spelled(text: str) -> str:
    """Give a unit as pint spells it: "deg_F" and "Deg F" are degF, "Newtons" are newtons."""
    plain = text.casefold() if WORD.fullmatch(text) else SQUARED.sub(r"\1**2", in_its_case(text))
    plain = _of_damping(plain)
    return SPELLINGS.get(text.casefold().replace("_", " "), plain)


def _of_damping(unit: str) -> str:
    """Give a damping coefficient's unit as pint reads it; others as they are."""
    forces = {"n": "N", "kn": "kN", "lb": "lbf"}
    return FORCE_SECONDS.sub(lambda found: f"{forces[found[1].casefold()]}*s", unit)


def in_its_case(text: str) -> str:
    """Give a unit whose letters are all small, or all capitals, with the capitals that its symbols have."""
    if text in ALONE or text not in (text.casefold(), text.upper()):
        return text
    return LETTERS.sub(lambda found: OF_ONE_CASE.get(found[0].casefold(), found[0]), text)


def _rounded(value: float) -> float:
    """Give a factor without the digits that its way through differences made."""
    return rounded_to(value, 13)


@cache
def _known(text: str) -> bool:
    """Tell whether pint knows the text as a unit of whatever."""
    if (
        text in ("-", "%", "1")
        or not re.fullmatch(r"[\w°µ^*/.\-·²³]{1,24}", text)
        or text.removeprefix("1/")[:1].isdigit()
        or POWERS.search(text)
    ):
        return text in ("-", "%", "1")
    try:
        _registry().parse_units(_spelled(text))
    except Exception:  # as above
        return False
    return True


@cache
def _registry() -> pint.UnitRegistry[float]:
    import pint

    return pint.UnitRegistry()
