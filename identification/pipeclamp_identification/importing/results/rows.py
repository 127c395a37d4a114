"""A table of results as rows of a campaign of metrics: storage and loss stiffness by whichever columns state them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.importing.channels.columns import Stated, channel_named, columns_option
from pipeclamp_identification.importing.channels.naming import unit_of
from pipeclamp_identification.importing.channels.questions import NONE
from pipeclamp_identification.importing.conditions import Settings
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.importing.results.part_size import (
    SIZE_WORDS,
    SIZES,
    ResultColumn,
    by_part_size,
    moduli_of,
    strains_of,
)
from pipeclamp_identification.importing.results.quantities import (
    AMPLITUDES,
    LOSSES,
    STIFFNESSES,
    TARGETS,
    amplitude_share,
    is_angular,
    is_called_modulus,
    is_in_phase,
    is_k,
    is_modulus,
    quantity_of,
    turned,
)
from pipeclamp_identification.importing.results.recognised import without_units
from pipeclamp_identification.units.stated import Conversion
from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.said import counted, few_of
from pipeclamp_models.base.units import CELSIUS

COLUMNS = {"amplitude": "amplitude_mm", "frequency": "frequency_Hz", "temperature": "temperature_C"}
"""Columns of runs.csv that channels fill as they are."""
STORAGE, LOSS = "storage_stiffness_N_mm", "loss_stiffness_N_mm"
SHARES = {0.5: "taken for a stroke from peak to peak, by its name", 2**0.5: "taken for an effective value, by its name"}
FOR_A_MODULUS = "12.5 N/mm"
"""What an option shows in the place of a part's stiffness for a unit of its modulus."""
PART_SIZE = "how stiff the part is for 1 of their unit: for 1 MPa its area over its height, in mm; for 1 Pa a millionth"
MODULUS_WORDS = f"\n  {FOR_A_MODULUS}: put there {PART_SIZE}"
FOR_A_STRAIN = "0.02 mm"
"""Likewise in the place of the part's deflection for a unit of its strain, or of an angle."""
MOST_OF_AN_ELLIPSE = 0.5
"""Damping ratio of an ellipse that has no storage stiffness."""
LOOP_ENERGIES = "(state such loops in runs.csv, by dissipated_energy_J and max_elastic_energy_J)"
BEYOND = -math.inf
"""Storage stiffness of what no ellipse loses."""
N_MM = 1e3
"""Of a joule."""


@dataclass(frozen=True)
class ResultRow:
    """A test: its row in the file, what was set, and its stiffness in phase and a quarter of a cycle before it."""

    row: int
    settings: Mapping[str, float]
    storage_N_mm: float
    loss_N_mm: float


@dataclass(frozen=True)
class ResultRows:
    """Rows that serve, rows that don't and why, the columns that they come from, and what is to be told."""

    rows: tuple[ResultRow, ...]
    left_out: tuple[tuple[int, str], ...]
    columns: tuple[ResultColumn, ...]
    unused: tuple[str, ...]
    notes: tuple[str, ...]


def result_rows(
    table: RawTable, stated: Sequence[Stated], own: Settings, of_file: Settings, sizes: Mapping[str, float]
) -> ResultRows:
    """Give the tests of a table of results.

    Args:
        table: as a file holds it.
        stated: what the user says of its channels.
        own: what the file states of all rows beside its columns, which go before it.
        of_file: what its name or a table of conditions states of them, which goes before its columns.
        sizes: height (size_mm) and area (area_mm2) of the part that are stated of the file.

    Raises:
        UserError: what is needed isn't there, or several columns may be it.
    """
    columns = _columns(table, stated)
    known = own.keys() | of_file.keys()
    columns |= by_part_size(table, columns, sizes, amplitude_known=COLUMNS["amplitude"] in known)
    bare = {one: channel for one, channel in without_units(table).items() if one not in columns}
    if bare:
        units = {one: _proposed_unit(one, channel) for one, channel in bare.items()}
        choices = [f"{one}={channel.heading} [{units[one]}]" for one, channel in bare.items() if units[one]]
        raise UserError(
            "holds results, a row a test, of which no units are stated; expected them, for example (check it):\n  "
            f"{columns_option([*map(_option, stated), *choices])}"
            f"{MODULUS_WORDS if FOR_A_MODULUS in units.values() else ''}"
        )
    for quantity in ("frequency", "amplitude"):
        if quantity not in columns and COLUMNS[quantity] not in known:
            raise UserError(_unknown_setting(quantity, table, stated, columns))
    amplitude, frequency = (_setting(one, table, columns, own, of_file) for one in ("amplitude", "frequency"))
    stiffness, used = _stiffness(table, stated, columns, amplitude, frequency)
    further = [one for one in columns.values() if one.quantity not in TARGETS]
    kept = [columns[quantity] for quantity in COLUMNS if quantity in columns]
    settings = {COLUMNS.get(one.quantity, one.quantity): one.values for one in (*kept, *further)}
    ratio = columns["damping_ratio"].values if "damping_ratio" in columns else np.zeros(table.length)
    rows: list[ResultRow] = []
    left_out: list[tuple[int, str]] = []
    for place in range(table.length):
        row = table.first_row + place
        set_there = {name: float(values[place]) for name, values in settings.items()}
        k = complex(stiffness[place])
        if why := _unusable(set_there, k, float(ratio[place])):
            left_out.append((row, why))
        else:
            rows.append(ResultRow(row, set_there, k.real, k.imag))
    taken = (*kept, *used, *further, *(columns[one] for one in SIZES if one in columns))
    headings = {one.channel.heading for one in taken}
    unused = tuple(one.heading for one in table.channels if one.heading not in headings)
    return ResultRows(tuple(rows), tuple(left_out), taken, unused, _notes_on(taken, used))


def _notes_on(taken: Sequence[ResultColumn], used: Sequence[ResultColumn]) -> tuple[str, ...]:
    """Say what columns are taken for whose names may mean something else.

    Args:
        taken: all columns that count.
        used: those of them that the stiffness comes from.
    """
    notes = [
        f"{one.channel.heading!r} is {words}"
        for one in taken
        if one.quantity in AMPLITUDES
        for share, words in SHARES.items()
        if amplitude_share(one.channel.name) == share
    ]
    notes += [
        f"{one.channel.heading!r} is called a damping ratio, and taken for a loss factor, which is twice that: where "
        f"it is what it is called, {columns_option([f'damping_ratio={one.channel.heading}'])}"
        for one in taken
        if one.quantity == "loss_factor" and quantity_of(one.channel) == "damping_ratio"
    ]
    if [one.quantity for one in used] == ["dynamic_stiffness", "damping_coefficient"] and _is_in_phase(used[0]):
        heading = used[0].channel.heading
        notes.append(
            f"{heading!r} stands beside a damping coefficient, and is taken for K in F = K x + C v: where it is the "
            f"ratio of the amplitudes, {columns_option([f'dynamic_stiffness={heading}'])}"
        )
    return tuple(notes)


def _proposed_unit(quantity: str, channel: Channel) -> str:
    """Give the unit that a channel without one may be in, as an option states it."""
    if quantity == "frequency" and is_angular(channel.name):
        return "rad/s"
    return FOR_A_MODULUS if quantity in STIFFNESSES and is_called_modulus(channel) else TARGETS[quantity]


def _unknown_setting(
    quantity: str, table: RawTable, stated: Sequence[Stated], columns: Mapping[str, ResultColumn]
) -> str:
    """Say that nothing states a setting, and how it can be stated: of strains, by the part's size."""
    target, column = TARGETS[quantity], COLUMNS[quantity]
    given = [_option(one) for one in stated]
    if quantity == "amplitude" and (strains := strains_of(table, columns)):
        moduli = [] if columns.keys() & set(STIFFNESSES) else _moduli(table, columns)
        example = columns_option([*given, f"{quantity}={strains[0].heading} [{FOR_A_STRAIN}]", *moduli])
        return (
            f"no column is the amplitude in mm, but {few_of([repr(one.heading) for one in strains])}; expected "
            f"{SIZE_WORDS} how far it moves for 1 of its unit (for 1 % of strain, a hundredth of its height), in "
            f"the place of {FOR_A_STRAIN}:\n  {example}{MODULUS_WORDS if moduli else ''}"
        )
    return (
        f"no column is the {quantity} in {target}; expected it to be stated:\n"
        f'  --columns "{",".join([*given, f"{quantity}=CHANNEL [{target}]"])}"\n'
        f"  or, where it is one and the same in a file, by --conditions TABLE.csv, a table with a row a file and the "
        f"columns file,{column}; or by --pattern, where files' names hold it\n  there are {_there(table)}"
    )


def _option(stated: Stated) -> str:
    """Give what was stated of a channel, as it is stated."""
    return f"{stated.ours}={'-' if stated.reversed else ''}{stated.channel}"


def _columns(table: RawTable, stated: Sequence[Stated]) -> dict[str, ResultColumn]:
    """Give the columns of each quantity: as stated, else by names and units."""
    found: dict[str, ResultColumn] = {}
    none: set[str] = set()
    for one in stated:
        if one.channel.casefold() == NONE:
            none.add(one.ours)
        else:
            found[one.ours] = _stated_column(table, one)
    taken = {one.channel.heading for one in found.values()}
    for quantity in TARGETS:
        if quantity in found or quantity in none:
            continue
        fitting = [
            one
            for one in table.channels
            if one.heading not in taken and quantity_of(one) == quantity and not is_modulus(one)
        ]
        if quantity == "damping_coefficient" and fitting and not found.keys() & set(STIFFNESSES):
            # K and C are the spring and the dashpot of a model
            for spring in [one for one in table.channels if one.heading not in taken and is_k(one)][:1]:
                found["storage_stiffness"] = _found("storage_stiffness", spring)
        if len(fitting) > 1:
            choices = [f"{quantity}={one.heading}" for one in fitting]
            raise UserError(
                f"{len(fitting)} columns may be the {quantity.replace('_', ' ')}: "
                f"{few_of([repr(one.heading) for one in fitting])}; expected it to be stated, for example (check it): "
                f"{columns_option(choices[:1])}"
            )
        if fitting:
            found[quantity] = _found(quantity, fitting[0])
    return found


def _found(quantity: str, channel: Channel) -> ResultColumn:
    conversion = turned(quantity, unit_of(channel), channel.name)
    assert conversion is not None
    return ResultColumn(quantity, channel, conversion, unit_of(channel))


def _stated_column(table: RawTable, stated: Stated) -> ResultColumn:
    """Give a column that was stated; what is no quantity of a result is a further condition, as it stands."""
    channel, unit = channel_named(table, stated)
    counts = unit or unit_of(channel)
    if stated.ours in ("time", "displacement", "force"):
        raise UsageError(
            f"--columns: got {stated.ours}={stated.channel}, but each row is a test of its own, with a frequency; "
            f"expected {', '.join(TARGETS)}"
        )
    if stated.ours not in TARGETS:
        return ResultColumn(stated.ours, channel, Conversion(-1.0 if stated.reversed else 1.0), counts, stated=True)
    conversion = turned(stated.ours, counts, channel.name)
    if conversion is None:
        target = FOR_A_MODULUS if is_modulus(channel) else TARGETS[stated.ours]
        raise UserError(
            f"--columns, {stated.ours}={stated.channel}: {counts or 'no unit'} is none of a {stated.ours}; expected "
            f"one that turns into {TARGETS[stated.ours]}, for example '{stated.ours}={channel.heading} [{target}]'"
        )
    return ResultColumn(stated.ours, channel, conversion, counts, stated=True)


def _moduli(table: RawTable, columns: Mapping[str, ResultColumn]) -> list[str]:
    """Give options that state the stiffness for a table's moduli; none where these don't do."""
    return [f"{quantity}={one.heading} [{FOR_A_MODULUS}]" for quantity, one in moduli_of(table, columns).items()]


def _setting(
    quantity: str, table: RawTable, columns: Mapping[str, ResultColumn], own: Settings, of_file: Settings
) -> Array:
    """Give the amplitude or frequency of each row, mm or Hz, as runs.csv will hold it; nan where none is known."""
    name = COLUMNS[quantity]
    if name not in of_file and quantity in columns:
        return columns[quantity].values
    stated = of_file.get(name, own.get(name))
    return np.full(table.length, stated if isinstance(stated, float) else np.nan)


def _stiffness(
    table: RawTable,
    stated: Sequence[Stated],
    columns: Mapping[str, ResultColumn],
    amplitude: Array,
    frequency: Array,
) -> tuple[ComplexArray, list[ResultColumn]]:
    """Give k' + i k'' of each row in N/mm and the columns that it comes from.

    Its amplitude, mm, and frequency, Hz, count where need is.

    Raises:
        UserError: nothing states both.
    """
    if "storage_stiffness" in columns and "loss_stiffness" in columns:
        both = columns["storage_stiffness"], columns["loss_stiffness"]
        return _complex(both[0].values, both[1].values), list(both)
    lag = next((columns[one] for one in LOSSES if one in columns), None)
    if lag is not None and lag.quantity in ("dissipated_energy", "damping_coefficient"):
        with np.errstate(divide="ignore", invalid="ignore"):
            by_energy = N_MM * lag.values / (np.pi * amplitude**2)
        loss = by_energy if lag.quantity == "dissipated_energy" else 2 * np.pi * frequency * lag.values
        if found := _by_loss(columns, lag, loss, amplitude):
            return found
    elif lag is not None:
        angle = _angle(lag, of_whole="dynamic_stiffness" in columns or "storage_stiffness" not in columns)
        if "dynamic_stiffness" in columns:
            dynamic = columns["dynamic_stiffness"].values
            return _complex(dynamic * np.cos(angle), dynamic * np.sin(angle)), [columns["dynamic_stiffness"], lag]
        if "storage_stiffness" in columns:
            storage = columns["storage_stiffness"]
            return _complex(storage.values, storage.values * np.tan(angle)), [storage, lag]
        if "force_amplitude" in columns:
            force = columns["force_amplitude"]
            with np.errstate(divide="ignore", invalid="ignore"):
                whole = force.values / amplitude
            return _complex(whole * np.cos(angle), whole * np.sin(angle)), [force, lag]
    if moduli := _moduli(table, columns):
        raise UserError(
            f"its moduli are the material's; expected {SIZE_WORDS}, in the place of {FOR_A_MODULUS}, {PART_SIZE}:\n"
            f"  {columns_option([*map(_option, stated), *moduli])}"
        )
    raise UserError(
        "no columns state how stiff each test was and what it lost; expected storage and loss stiffness, or, with loss "
        "angle, loss factor, damping ratio, damping coefficient or dissipated energy, dynamic stiffness or the "
        "amplitudes of force and displacement, for example:\n"
        f'  --columns "dynamic_stiffness=CHANNEL [N/mm],loss_angle=CHANNEL [deg]"\n  there are {_there(table)}'
    )


def _by_loss(
    columns: Mapping[str, ResultColumn], lost: ResultColumn, loss: Array, amplitude: Array
) -> tuple[ComplexArray, list[ResultColumn]] | None:
    """Give k' + i k'' by k'', N/mm, that a column of what is lost states, and the columns; None where these don't do.

    The energy that a cycle loses is dW = pi k'' A^2, a damping coefficient k'' over the angular frequency. k' is
    `BEYOND` where no ellipse of the amplitudes' stiffness loses so much.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        if "storage_stiffness" in columns:
            return _complex(columns["storage_stiffness"].values, loss), [columns["storage_stiffness"], lost]
        if "dynamic_stiffness" in columns:
            if lost.quantity == "damping_coefficient" and _is_in_phase(columns["dynamic_stiffness"]):
                return _complex(columns["dynamic_stiffness"].values, loss), [columns["dynamic_stiffness"], lost]
            stiff, whole = columns["dynamic_stiffness"], columns["dynamic_stiffness"].values
        elif "force_amplitude" in columns:
            stiff, whole = columns["force_amplitude"], columns["force_amplitude"].values / amplitude
        else:
            return None
        real = np.where(loss >= whole, BEYOND, np.sqrt(whole**2 - loss**2))
        return _complex(real, loss), [stiff, lost]


def _is_in_phase(stiffness: ResultColumn) -> bool:
    return not stiffness.stated and is_in_phase(stiffness.channel)


def _angle(lag: ResultColumn, *, of_whole: bool) -> Array:
    """Give the loss angle of each row, rad; nan where no ellipse loses so much.

    A damping ratio is what a cycle loses over 4 pi times the energy of the secant: dW = 2 pi zeta k X^2 (ISO 22762), so
    that k'' is 2 zeta times the stiffness beside it.

    Args:
        lag: the column.
        of_whole: whether a damping ratio is of the amplitudes' stiffness, else of the storage stiffness.
    """
    if lag.quantity == "loss_angle":
        return lag.values
    if lag.quantity == "loss_factor":
        return np.arctan(lag.values)
    if not of_whole:
        return np.arctan(2.0 * lag.values)
    ratio: Array = np.where(np.abs(lag.values) < MOST_OF_AN_ELLIPSE, lag.values, np.nan)
    return np.arcsin(ratio / MOST_OF_AN_ELLIPSE)


def _complex(real: Array, imaginary: Array) -> ComplexArray:
    whole: ComplexArray = np.empty(len(real), dtype=np.complex128)
    whole.real, whole.imag = real, imaginary
    return whole


def _unusable(settings: Mapping[str, float], k: complex, damping_ratio: float) -> str:
    """Say why a test can't be used, "" where it can."""
    if np.isnan(k.real) and damping_ratio >= MOST_OF_AN_ELLIPSE:
        return f"no ellipse has a damping ratio of {MOST_OF_AN_ELLIPSE:g} or more {LOOP_ENERGIES}"
    if k.real == BEYOND:
        return f"no ellipse of its stiffness and amplitude loses so much energy {LOOP_ENERGIES}"
    if not all(np.isfinite([*settings.values(), k.real, k.imag])):
        return "a number is blank"
    for name in ("amplitude_mm", "frequency_Hz"):
        if name in settings and settings[name] <= 0:
            return f"its {name} isn't above 0"
    if settings.get("temperature_C", 0.0) <= -CELSIUS:
        return f"its temperature isn't above {-CELSIUS:g} °C"
    if k.real <= 0:
        return "its storage stiffness isn't above 0"
    return "" if k.imag > 0 else "its loss stiffness isn't above 0, so that it would make energy"


def left_out_words(left_out: Sequence[tuple[int, str]], length: int) -> list[str]:
    """Say how many of a table's rows can't be used, and why, by reason."""
    reasons: dict[str, list[int]] = {}
    for row, why in left_out:
        reasons.setdefault(why, []).append(row)
    return [
        f"{len(rows)} of {counted(length, 'row')} left out, {why}: row{'s' if len(rows) > 1 else ''} "
        f"{few_of([str(row) for row in rows])}"
        for why, rows in reasons.items()
    ]


def _there(table: RawTable) -> str:
    return few_of([repr(one.heading) for one in table.channels])
