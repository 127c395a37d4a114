"""The bands of a frequency response, and the words and columns that say them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pipeclamp_models.base.arrays import Array
from pipeclamp_system.bands.band import Band, beside_words, ends_words, origin_words, steps_of
from pipeclamp_system.response.curves import FrequencyResponse, label


@dataclass(frozen=True, eq=False)
class PieceBand:
    """The band of a piece of a curve at one point: its ends at the frequencies of its states, mm, shape (S,) each.

    nan where the laws that are as likely have no such state there.
    """

    low: Array
    high: Array


@dataclass(frozen=True)
class PeakBand:
    """The highest state of a curve at one point.

    Attributes:
        amplitude: mm; frequency: Hz.
        inside: whether it lies inside the range of frequencies.
    """

    amplitude: Band
    frequency: Band
    inside: bool


@dataclass(frozen=True)
class CurveBands:
    """The bands of one curve.

    Attributes:
        peaks: of each clamp and probe.
        turns: frequencies, Hz, at which the curve turns back, in the order of its states.
        pieces: of each piece of the curve, of each clamp and probe.
        detached: how many branches nothing joins to the curve: with the law, and at the low and the high end;
            None where no motion was found there.
    """

    peaks: tuple[PeakBand, ...]
    turns: tuple[Band, ...]
    pieces: tuple[tuple[PieceBand, ...], ...]
    detached: tuple[int, int | None, int | None]


@dataclass(frozen=True)
class ResponseBands:
    """The bands of a frequency response.

    Attributes:
        response: the response.
        per_cent: that each band holds.
        curves: the bands of each of its curves.
        limits: mm, by clamp or probe.
        gaps: what the laws' files don't tell, in words.
    """

    response: FrequencyResponse
    per_cent: float
    curves: tuple[CurveBands, ...]
    limits: Mapping[str, float]
    gaps: tuple[str, ...]

    def words(self) -> list[str]:
        """Say how sure the response is."""
        lines = []
        for curve, bands in zip(self.response.curves, self.curves, strict=True):
            name = label(curve.temperature, curve.level)
            for point, peak in zip(self.response.points, bands.peaks, strict=True):
                lines.append(f"{name}: {self._peak_words(point, peak)}")
            if bands.turns:
                jumps = ", ".join(ends_words(turn, "Hz", self.per_cent) for turn in bands.turns)
                lines.append(f"{name}: the curve turns back, and a sweep jumps, at {jumps}")
            lines += [f"{name}: {words}" for words in _detached_words(bands.detached)]
        return [*lines, *self._origin(), *self.gaps]

    def _origin(self) -> list[str]:
        """Say what the band that is widest beside its peak comes from."""
        peaks = [
            (f"the peak at {point}, {label(curve.temperature, curve.level)}", peak.amplitude)
            for curve, bands in zip(self.response.curves, self.curves, strict=True)
            for point, peak in zip(self.response.points, bands.peaks, strict=True)
        ]
        name, widest = max(peaks, key=lambda one: one[1].deviation / one[1].value)
        return origin_words(name, widest)

    def _peak_words(self, point: str, peak: PeakBand) -> str:
        where = "" if peak.inside else ", at the end of the range of frequencies"
        words = (
            f"peak at {point} {ends_words(peak.amplitude, 'mm', self.per_cent)} at "
            f"{ends_words(peak.frequency, 'Hz', self.per_cent)}{where}{beside_words(peak.amplitude, 'the peak in mm')}"
        )
        if point in self.limits:
            chance = peak.amplitude.beyond(self.limits[point], steps_of(self.per_cent))
            words += f"; above {self.limits[point]:g} mm with a probability of {_probability(chance)}"
        return words

    def columns(self) -> list[dict[str, float]]:
        """Give the ends of the bands for each state of the curves, in their order, by the header of their column."""
        rows = []
        for curve, bands in zip(self.response.curves, self.curves, strict=True):
            for piece, of_points in zip(curve.pieces, bands.pieces, strict=True):
                for place in range(len(piece)):
                    row: dict[str, float] = {}
                    for name, band in zip(self.response.points, of_points, strict=True):
                        row[f"{name}.s_low [mm]"] = float(band.low[place])
                        row[f"{name}.s_high [mm]"] = float(band.high[place])
                    rows.append(row)
        return rows


def _probability(chance: float) -> str:
    if chance < 1e-3 or chance > 1 - 1e-3:
        return "less than 0.1%" if chance < 0.5 else "more than 99.9%"
    return f"{100 * chance:.2g}%" if chance < 0.995 else f"{100 * chance:.1f}%"


def _detached_words(counts: tuple[int, int | None, int | None]) -> list[str]:
    here, *ends = counts
    lines = [
        f"no motion is found with the law at the {name} end of its band, which is foretold from the law alone"
        for name, count in zip(("low", "high"), ends, strict=True)
        if count is None
    ]
    if any(count not in (None, here) for count in ends):
        named = zip(("low", "high"), ends, strict=True)
        at_ends = [f"at the {name} end of the band {count or 'none'}" for name, count in named if count is not None]
        lines.append(f"branches apart from the curve: {here or 'none'}; {', '.join(at_ends)}")
    return lines
