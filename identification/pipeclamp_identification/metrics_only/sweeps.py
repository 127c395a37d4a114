"""Metrics over what was varied: a curve for each setting of what else varies, as a test engineer draws them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.loops.one_condition import levels_of, same_setting
from pipeclamp_identification.metrics_only.campaign import MetricCampaign
from pipeclamp_models.base.arrays import Array

SCATTERED = 3.0
"""Times what settings lie apart at most, by which values may lie off their mean: beyond, they go from one setting to
another without a gap."""


@dataclass(frozen=True)
class Curve:
    """Tests of one setting: its specimen ("" where there is one), its levels, and its rows of the campaign by rising
    abscissa."""

    specimen: str
    held: tuple[tuple[str, float], ...]
    rows: tuple[int, ...]


@dataclass(frozen=True)
class Sweep:
    """A quantity that was varied.

    Attributes:
        quantity: a column of runs.csv.
        values: of all tests, shape (R,); nan where it isn't known.
        curves: of tests between which nothing else varies, but what was never set to levels.
        drifting: columns that vary without levels, as a temperature that rises all along: points of a curve differ in
            them, too.
    """

    quantity: str
    values: Array
    curves: tuple[Curve, ...]
    drifting: tuple[str, ...]


def values_of(campaign: MetricCampaign) -> Mapping[str, Array]:
    """Give what was set in each test, by column of runs.csv, shape (R,); nan where it isn't known."""
    runs, setups = campaign.runs, [run.setup for run in campaign.runs]
    columns = {
        "frequency_Hz": [run.frequency_Hz for run in runs],
        "amplitude_mm": [run.amplitude_mm for run in runs],
        "temperature_C": [setup.temperature_C for setup in setups],
        "density_g_cm3": [setup.density_g_cm3 for setup in setups],
        "first_cycle": [setup.first_cycle for setup in setups],
        **{name: [setup.conditions[name] for setup in setups] for name in campaign.condition_columns},
    }
    return {name: np.array(values, dtype=np.float64) for name, values in columns.items()}


@dataclass(frozen=True)
class _Settings:
    """What was set in each test.

    Attributes:
        values: by column of runs.csv, shape (R,) each; nan where it isn't known.
        levels: the level of each value, likewise.
        drifting: columns that vary without levels.
        varied: columns that vary, those among them.
        specimens: of each test, "" where it has none.
    """

    values: Mapping[str, Array]
    levels: Mapping[str, Array]
    drifting: Sequence[str]
    varied: Sequence[str]
    specimens: Sequence[str]


def _settings_of(campaign: MetricCampaign) -> _Settings:
    values = values_of(campaign)
    levels = {name: levels_of(name, own) for name, own in values.items()}
    drifting = [name for name in values if _drifts(name, values[name], levels[name])]
    varied = [name for name in values if name in drifting or len(_known(levels[name])) > 1]
    return _Settings(values, levels, drifting, varied, [run.setup.specimen or "" for run in campaign.runs])


def sweeps_of(campaign: MetricCampaign) -> tuple[Sweep, ...]:
    """Give each quantity that varies, in the order of `values_of`, with the curves that can be drawn over it."""
    settings = _settings_of(campaign)
    sweeps = []
    for quantity in settings.varied:
        curves = _curves_over(quantity, settings)
        if any(len(curve.rows) > 1 for curve in curves):
            others = tuple(name for name in settings.drifting if name != quantity)
            sweeps.append(Sweep(quantity, settings.values[quantity], curves, others))
    return tuple(sweeps)


def _curves_over(quantity: str, settings: _Settings) -> tuple[Curve, ...]:
    """Give the curves over a quantity: of tests of one specimen that differ in nothing else that was set to levels."""
    values, levels = settings.values[quantity], settings.levels
    held = [name for name in settings.varied if name != quantity and name not in settings.drifting]
    groups: dict[tuple[str, tuple[tuple[str, float], ...]], list[int]] = {}
    for row in np.flatnonzero(np.isfinite(values)).tolist():
        key = tuple((name, float(levels[name][row])) for name in held if np.isfinite(levels[name][row]))
        groups.setdefault((settings.specimens[row], key), []).append(row)
    several = len(set(settings.specimens)) > 1
    curves = [
        Curve(specimen if several else "", key, tuple(sorted(rows, key=_by(values))))
        for (specimen, key), rows in groups.items()
        if len({float(levels[quantity][row]) for row in rows}) > 1 or quantity in settings.drifting
    ]
    return tuple(sorted(curves, key=lambda curve: (curve.specimen, [value for _, value in curve.held])))


def _by(values: Array) -> Callable[[int], float]:
    return lambda row: float(values[row])


def _known(values: Array) -> set[float]:
    return set(values[np.isfinite(values)].tolist())


def _drifts(quantity: str, values: Array, levels: Array) -> bool:
    """Tell whether values go all the way between levels, so that those that lie together are no setting."""
    known = np.isfinite(values)
    return bool(np.any(np.abs(values - levels)[known] > SCATTERED * same_setting(quantity, levels[known])))
