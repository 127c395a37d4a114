"""How well a channel's name and unit fit a quantity."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence

from pipeclamp_identification.campaign.runs_table import NUMBER_COLUMNS, TEXT_COLUMNS, meant_column
from pipeclamp_identification.importing.raw import Channel, LabelColumn
from pipeclamp_identification.units.stated import (
    OURS,
    QUANTITY_OF,
    Quantity,
    conversion,
    conversion_of_rate,
    quantity_of_unit,
    unit_in_name,
)
from pipeclamp_models.base.errors import UserError

SEGMENT = "segment"
"""A channel that tells one run of a file from the next."""
EACH_CYCLE = "each-cycle"
"""States in its place that each cycle of a file is a run; and is the name of the channel that then numbers them."""
WORDS: Mapping[Quantity, tuple[str, ...]] = {
    "time": (
        "time", "timestamp", "datetime", "zeit", "zeitstempel", "uhrzeit", "temps", "tempo", "tiempo", "elapsed", "t",
        "millis",
    ),
    "displacement": (
        "displacement", "displ", "disp", "stroke", "travel", "position", "pos", "lvdt", "deflection", "extension",
        "crosshead", "deformation", "verformung",
        "weg", "kolbenweg", "hub", "verschiebung", "auslenkung", "traverse", "deplacement", "course",
        "spostamento", "corsa", "desplazamiento", "y",
    ),
    "force": (
        "force", "load", "loadcell", "kraft", "last", "kraftmessdose", "effort", "forza", "carico", "fuerza", "charge",
        "carga", "f",
    ),
    "temperature": ("temperature", "temperatur", "temp", "thermocouple", "thermoelement", "temperatura", "tc", "t"),
    SEGMENT: ("segment", "block", "sequence", "sequenz", "abschnitt", "schritt", "teilversuch", "step", "run", "lauf"),
}  # fmt: skip
"""Words that name a quantity, folded; a compound may end with one that is long enough (Kolbenweg, Axialkraft)."""
ACROSS = frozenset(("shear", "lateral", "horizontal", "transverse", "restoring"))
"""Words that name a force beside a unit of one, as of a bearing that bears a load as well."""
SPECIMENS = frozenset(
    ("specimen", "probe", "probekoerper", "pruefkoerper", "pruefling", "eprouvette", "provino", "probeta")
)
"""Words that name what is tested."""
LABELS = SPECIMENS | frozenset(("test", "versuch", "pruefung", "experiment", "essai", "prova", "ensayo"))
"""Words that name a column of texts which tells one run from the next, alone or beside those of a name."""
LABELLED = frozenset(("name", "id", "label", "no", "nr", "number", "nummer", "bezeichnung", "nom", "nome", "nombre"))
ENDINGS = 3
"""Letters from which on a compound's last word counts."""
CLOCKS = frozenset(("time", "timestamp", "zeit", "zeitstempel", "temps", "tempo", "tiempo"))
"""Words of time that no other quantity's name holds but where it is the time of that one."""
DATES = ("date", "datum")
"""Words that stand beside those of a time where stamps hold both."""
OTHERS = frozenset(
    (
        *("command", "cmd", "setpoint", "soll", "sollwert", "target", "demand", "reference", "fuehrung"),
        *("error", "abweichung", "velocity", "vel", "speed", "geschwindigkeit", "rate", "acc", "accel", "acceleration"),
        *("beschleunigung", "peak", "valley", "max", "maximum", "min", "minimum", "mean", "mittelwert", "strain"),
        *("dehnung", "stress", "spannung", "pressure", "druck", "limit", "date", "datum", "bewegung", "energy"),
    )
)
"""Words of what is derived from a channel, asked of the machine, or something else."""
EXTREMES = frozenset(("peak", "valley", "max", "maximum", "min", "minimum"))
"""Those of them that a cycle reached."""
CYCLES = frozenset(("cycle", "cycles", "zyklus", "zyklen", "lastspiel", "lastspiele", "cyclenumber"))
"""Words of what counts cycles."""
COUNTS = CYCLES | frozenset(
    ("count", "counter", "zaehler", "index", "sample", "samples", "point", "points", "scan", "number", "nr", "no")
)
"""Words of what only counts."""
SETTINGS_CALLED: Mapping[Quantity, tuple[str, ...]] = {
    "amplitude": ("amplitude", "ampl", "amp", "ampiezza", "amplitud"),
    "frequency": ("frequency", "freq", "frequenz", "frequence", "frequenza", "frecuencia"),
    "temperature": WORDS["temperature"],
    "density": ("density", "dichte", "densite", "densita", "densidad"),
}
"""Words that name what is set in a run, folded."""
SPELT = str.maketrans(
    {"ß": "ss", "ü": "ue", "ä": "ae", "ö": "oe", "ł": "l", "Ł": "L", "đ": "d", "Đ": "D", "ø": "o", "Ø": "O", "ı": "i"}
)
"""Letters that are spelt so where there is none of them, or that are no letter of ASCII with an accent."""
LETTERS = 1
"""Words of so few letters count only beside a unit."""
CLEAR_NAME = 4
"""Letters from which on a word names a quantity without a fitting unit beside it."""


def unit_of(channel: Channel) -> str:
    """Give the unit that a file states of a channel: beside its name, or in it."""
    return channel.unit or unit_in_name(channel.name)[1]


def is_of_another(quantity: Quantity, channel: Channel) -> bool:
    """Tell whether a channel is called so and stands in a unit, but in none of the quantity."""
    name, unit = _name_of(channel), unit_of(channel)
    words = [word for word in words_of(name) if len(word) >= CLEAR_NAME]
    return bool(unit) and not fits_unit(quantity, unit) and not _is_other(words) and _is_named(quantity, words, True)


def rank(quantity: Quantity, channel: Channel) -> int:
    """Give how well a channel's name and unit fit a quantity: 0 not at all, 4 our own name."""
    unit = unit_of(channel)
    if QUANTITY_OF.get(channel.name) == quantity:
        return 4
    words = words_of(_name_of(channel))
    if (
        quantity == SEGMENT
        and isinstance(channel, LabelColumn)
        and LABELS & set(words)
        and set(words) <= LABELS | LABELLED
    ):
        return 3
    if quantity == "time" and _is_named(quantity, dated := [word for word in words if word not in DATES], bool(unit)):
        words = dated
    if _is_other(words):
        return 0
    of_unit = fits_unit(quantity, unit)
    if unit and not of_unit:
        return 0
    if quantity == "force" and of_unit and not ACROSS.isdisjoint(words):
        return 3
    if _is_named(quantity, words, beside_unit=bool(unit)):
        # Dewesoft's "Data1_time_Weg" is the time of "Data1_Weg"
        if not unit and quantity not in ("time", SEGMENT) and not CLOCKS.isdisjoint(words):
            return 1
        # a name and a unit: sure; a name alone: its unit must be asked
        return 3 if unit or quantity == SEGMENT else 2
    # without a name a unit is of what it is of first: m are metres, and minutes only of what is called a time
    foremost = quantity_of_unit(unit) in (None, quantity)
    named_otherwise = any(_is_named(other, words, True) for other in WORDS if other != quantity)
    if unit and quantity != SEGMENT and foremost and not named_otherwise:
        return 1
    return 0


def serves(quantity: Quantity, channel: Channel) -> bool:
    """Tell whether a channel's unit fits a quantity and its name doesn't say that it is derived or asked for."""
    return fits_unit(quantity, unit_of(channel)) and not _is_other(words_of(_name_of(channel)))


def is_something_else(quantity: Quantity, channel: Channel) -> bool:
    """Tell whether name and unit both say that a channel is none of the quantity: another one, or derived from one."""
    unit = unit_of(channel)
    if not unit or fits_unit(quantity, unit):
        return False
    return _is_other(words_of(_name_of(channel))) or any(
        rank(other, channel) > 2 for other in OURS if other != quantity
    )


def is_extreme(quantity: Quantity, channel: Channel) -> bool:
    """Tell whether a channel is what a quantity reached in each cycle or block, no sample of it."""
    words = words_of(_name_of(channel))
    return fits_unit(quantity, unit_of(channel)) and not EXTREMES.isdisjoint(words) and _is_named(quantity, words, True)


def integrations_of(channel: Channel) -> int:
    """Give how often a channel is integrated to a displacement: once in a unit of speed, twice of acceleration, else 0.

    What is called a force isn't, for g is a unit of both.
    """
    rate = conversion_of_rate(unit_of(channel))
    return 0 if rate is None or _is_named("force", words_of(channel.name), True) else rate.integrated


def is_frequency(channel: Channel) -> bool:
    """Tell whether a channel holds frequencies, as the axis of a spectrum does, by its name."""
    return not set(SETTINGS_CALLED["frequency"]).isdisjoint(words_of(_name_of(channel)))


def is_count(channel: Channel) -> bool:
    """Tell whether a channel counts cycles or samples, by its name."""
    return not COUNTS.isdisjoint(words_of(_name_of(channel)))


def counts_cycles(heading: str) -> bool:
    """Tell whether a channel counts cycles, by its heading."""
    return not CYCLES.isdisjoint(words_of(unit_in_name(heading)[0]))


def is_measured(heading: str) -> bool:
    """Tell whether a channel is neither asked for nor derived nor a count, by its heading."""
    name, unit = unit_in_name(heading)
    words = words_of(name)
    return not _is_other(words) and COUNTS.isdisjoint(words) and quantity_of_unit(unit) != "time"


def condition_name(heading: str) -> str:
    """Give a name in runs.csv for a channel's mean, with the channel's unit where names can hold it."""
    name, unit = unit_in_name(heading)
    words = re.findall(r"[a-z][a-z0-9]*|(?<=.)[0-9]+", _folded(name).lstrip("0123456789"))
    plain = "_".join([*words, *([unit] if re.fullmatch(r"[A-Za-z]{1,6}", unit) else [])])
    return plain if plain[:1].isalpha() and not is_known(plain) else f"measured_{plain}".rstrip("_")


def setting_called(name: str) -> str:
    """Give the condition of a run that a name means: amplitude, frequency, temperature or density; "" for others."""
    words = words_of(name)
    return next((quantity for quantity, known in SETTINGS_CALLED.items() if len(words) == 1 and words[0] in known), "")


def names_specimen(name: str) -> bool:
    """Tell whether a name is that of what is tested: "Specimen", "Prüfling Nr"."""
    words = set(words_of(name))
    return bool(words & SPECIMENS) and words <= SPECIMENS | LABELLED


def is_known(column: str) -> bool:
    """Tell whether runs.csv has a column of this name, or one that the name probably means."""
    return column in NUMBER_COLUMNS or column in TEXT_COLUMNS or meant_column(column) is not None


def _name_of(channel: Channel) -> str:
    return channel.name if channel.unit else unit_in_name(channel.name)[0]


def _is_other(words: Sequence[str]) -> bool:
    return any(word in OTHERS or word.endswith(("geschwindigkeit", "beschleunigung")) for word in words)


def fits_unit(quantity: Quantity, unit: str) -> bool:
    """Tell whether a unit is one of the quantity."""
    if quantity == SEGMENT:
        return unit in ("", "-", "1")
    if not unit:
        return False
    if quantity_of_unit(unit) == quantity:
        return True
    try:
        conversion(quantity, unit)
    except UserError:
        return False
    return True


def _is_named(quantity: Quantity, words: Sequence[str], beside_unit: bool) -> bool:
    for known in WORDS[quantity]:
        for word in words:
            if len(known) <= LETTERS and not beside_unit:
                continue
            if word == known or (len(known) >= ENDINGS and len(word) > len(known) and word.endswith(known)):
                return True
    return False


def words_of(name: str) -> list[str]:
    """Give a name's words, folded: no capitals, accents or digits."""
    return re.findall(r"[a-z]+", _folded(name))


def _folded(name: str) -> str:
    """Give a name without capitals and accents, blanks where capitals begin words."""
    text = name.translate(SPELT)
    plain = unicodedata.normalize("NFKD", re.sub(r"([a-z])([A-Z])", r"\1 \2", text))
    return "".join(one for one in plain if not unicodedata.combining(one)).casefold()
