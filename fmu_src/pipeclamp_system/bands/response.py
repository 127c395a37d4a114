"""The bands of a frequency response: of its curves, its peaks and its jumps."""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.toml_file import unknown as unknown_name
from pipeclamp_models.law.file import write_law
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_system.bands.band import band_of, steps_of
from pipeclamp_system.bands.described import refuse_unknown, unknown_of
from pipeclamp_system.bands.marks import Moving
from pipeclamp_system.bands.quantities import Unknown, normal_draws
from pipeclamp_system.bands.response_bands import CurveBands, PeakBand, PieceBand, ResponseBands
from pipeclamp_system.bands.sensitivity import conditions_at, moves, with_laws
from pipeclamp_system.bands.varied import gaps
from pipeclamp_system.description.system import SystemDescription, read_system
from pipeclamp_system.response.curves import Curve, FrequencyResponse, label
from pipeclamp_system.response.run import curve_of
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.described import response_table, steady_clamps, steady_system
from pipeclamp_system.steady.states import SteadyState, amplitudes_of

MOST_DRAWS = 400
"""Of what isn't known, that the bands of curves are made of."""
TELLING_SHARE = 0.5
"""Of its own band, that a point must move at the ends of the first one's, for these to tell how its band bends."""

DAMP_IT = "expected [damping] of the pipe, or a law with damping"
"""What a band needs."""


def response_bands(
    path: Path,
    response: FrequencyResponse,
    per_cent: float,
    limits: Mapping[str, float] | None = None,
    progress: Progress = silent,
) -> ResponseBands:
    """Give the bands of a system's frequency response.

    To first order by exact derivatives, then held against the response at the two ends of the band of each curve's
    first peak: where that bends, the bands follow it.

    Args:
        path: SYSTEM.toml, that the response is of.
        response: the response.
        per_cent: that each band holds, such as 95.
        limits: mm that clamps or probes may move, by name.
        progress: told what is being done.

    Raises:
        UserError: the response at an end isn't found.
        UsageError: as of `refuse`.
    """
    refuse(path, per_cent, limits or {})
    system = banded_system(path, response)
    curves = []
    for curve in response.curves:
        progress(f"band of {label(curve.temperature, curve.level)}")
        curves.append(system.bands(curve, per_cent))
    return ResponseBands(response, per_cent, tuple(curves), limits or {}, gaps(system.unknown.laws))


def refuse(path: Path, per_cent: float, limits: Mapping[str, float]) -> None:
    """Refuse what no band can be given of, before anything is computed.

    Raises:
        UserError: the system can't be read, or no clamp has a law that tells how sure it is.
        UsageError: the share can't be held by a band, or a limit is for no clamp or probe, or none.
    """
    steps_of(per_cent)
    description = read_system(path)
    refuse_unknown(description, path.parent, str(path))
    known = [clamp.at for clamp in description.clamps]
    if description.pipe.file is not None:
        known += [probe.name for probe in read_pipe(path.parent / description.pipe.file).probes]
    for name, limit in limits.items():
        if not 0 < limit < math.inf:
            raise UsageError(f"--limit: got {name}={limit:g}; expected a displacement above 0 mm")
        if name not in known:
            raise UsageError(f"--limit: {unknown_name(name, known, 'clamp or probe')}")


def banded_system(path: Path, response: FrequencyResponse, *, by_clamp: bool = False) -> BandedSystem:
    """Give the system of a response, SYSTEM.toml, with what isn't known of its clamps.

    Args:
        path: the system's file.
        response: its response.
        by_clamp: whether what a law's form may be off stands there for each of its clamps by itself.

    Raises:
        UserError: the system can't be read, or a motion of it was found in time or isn't bounded.
    """
    in_time = [state.frequency for curve in response.curves for way in curve.followed.in_time for state in way]
    if in_time:
        raise UserError(
            f"{path}: from {min(in_time):.4g} to {max(in_time):.4g} Hz a motion was found in time, and bands follow "
            "from motions that are balanced; expected other ends of [response], or harmonics stated there, with which "
            "more can be balanced"
        )
    if any(curve.followed.unbounded for curve in response.curves):
        raise UserError(
            f"{path}: its response isn't bounded, for lack of damping, so that no band of it is known; {DAMP_IT}"
        )
    undamped = [state.frequency for curve in response.curves for state in curve.states if state.neutral]
    if undamped:
        raise UserError(
            f"{path}: nothing damps its motion from {min(undamped):.4g} to {max(undamped):.4g} Hz, so that no band of "
            f"it is known; {DAMP_IT}"
        )
    description = read_system(path)
    what = unknown_of(description, path.parent)
    return BandedSystem(path, description, what.by_clamp() if by_clamp else what)


class BandedSystem:
    """A described system with what isn't known of its clamps."""

    def __init__(self, path: Path, description: SystemDescription, unknown: Unknown) -> None:
        self.path, self.description, self.unknown = path, description, unknown
        self.table = response_table(description, str(path))
        self.pipe: ReducedPipe = reduce(read_pipe(path.parent / str(description.pipe.file)))

    def bands(self, curve: Curve, per_cent: float) -> CurveBands:
        """Give the bands of a curve."""
        steps = steps_of(per_cent)
        moving = self.moving(curve)
        sizes = self.unknown.scales
        peaks, slopes = [], []
        for of_point in moving:
            # of all pieces that with the highest state
            index = max(range(len(of_point)), key=lambda place: of_point[place].peak()[1])
            frequency, amplitude, inside = of_point[index].peak()
            by_frequency, by_amplitude = of_point[index].peak_moves(sizes)
            slopes.append(by_amplitude)
            off_frequency, off_amplitude = of_point[index].peak_errors()
            peaks.append(
                PeakBand(
                    band_of(amplitude, by_amplitude, self.unknown, steps, off_amplitude),
                    band_of(frequency, by_frequency, self.unknown, steps, off_frequency),
                    inside,
                )
            )
        turns = tuple(
            band_of(piece.turn(at), piece.turn_moves(at), self.unknown, steps)
            for piece in moving[0] for at in piece.turns()
        )  # fmt: skip
        # what the solver leaves out is no law's: no law at an end of the band has it
        told = np.where(self.unknown.of_kind("solution"), 0.0, slopes[0])
        deviation = float(np.sqrt(told @ self.unknown.covariance @ told))
        towards = self.unknown.covariance @ told / max(deviation, 1e-300)
        means = self.unknown.means
        ends = [self._end(curve, means + side * steps * towards) for side in (-1, 1)]
        middle = self._end(curve, means, apart=False) if means.any() else curve
        followed = tuple(
            _followed(
                peak,
                None if middle is None else _peak_of(middle, place) if means.any() else peak.amplitude.value,
                [None if end is None else _peak_of(end, place) for end in ends],
                [side * steps * float(slopes[place] @ towards) for side in (-1, 1)],
            )
            for place, peak in enumerate(peaks)
        )
        draws = normal_draws(MOST_DRAWS, self.unknown)
        pieces = tuple(
            tuple(
                self._piece(of_point[index], peak, bent, draws, draws @ slope, per_cent)
                for of_point, peak, bent, slope in zip(moving, peaks, followed, slopes, strict=True)
            )
            for index in range(len(curve.pieces))
        )
        low, high = (None if end is None else len(end.detached) for end in ends)
        return CurveBands(followed, turns, pieces, (len(curve.detached), low, high))

    def _end(self, curve: Curve, amounts: Array, *, apart: bool = True) -> Curve | None:
        """Give the curve with laws that are off, as of `solved`; None where no such motion is found."""
        try:
            return self.solved(curve, amounts, apart=apart)
        except UserError:
            return None

    def _piece(
        self, piece: Moving, peak: PeakBand, bent: PeakBand, draws: Array, moved: Array, per_cent: float
    ) -> PieceBand:
        """Give the band of a piece, whose peak moves so much in each draw, (N,): bent as that of the peak is."""
        straight, own = peak.amplitude, bent.amplitude
        up = (own.high - own.middle) / max(straight.high - straight.middle, 1e-300)
        down = (own.middle - own.low) / max(straight.middle - straight.low, 1e-300)
        bent_draws = self.unknown.means + draws * np.where(moved > 0, up, down)[:, None]
        return PieceBand(*piece.band(bent_draws, per_cent))

    def moving(self, curve: Curve) -> list[list[Moving]]:
        """Give, for each clamp and probe, the pieces of a curve with how they move."""
        where, folder = str(self.path), self.path.parent
        system = steady_system(
            self.description, self.pipe, folder, curve.temperature, curve.level, self.table.harmonics, where
        )
        own = [one for _, one in steady_clamps(self.description, self.pipe, folder, curve.temperature, where)]
        return moving_of(system, with_laws(own, self.unknown), curve.pieces, self.unknown)

    def solved(self, curve: Curve, amounts: Array, *, apart: bool = True) -> Curve:
        """Give the curve with laws that are off by amounts of what isn't known; nothing is linear in that.

        Args:
            curve: with the laws as they are.
            amounts: of what isn't known, (Q,).
            apart: whether branches that nothing joins to the curve are sought too: most of the time.

        Raises:
            UserError: no such motion is found.
        """
        highest = max(curve.states, key=lambda state: amplitudes_of(state)[0])
        found = steady_clamps(self.description, self.pipe, self.path.parent, curve.temperature, str(self.path))
        at = [conditions_at(clamp, highest, place) for place, (_, clamp) in enumerate(found)]
        folder = Path(tempfile.mkdtemp(prefix="pipeclamp_"))
        try:
            clamps = []
            for place, source in enumerate(self.description.clamps):
                file = self.unknown.laws[place].with_changes(
                    self.unknown.changes(place, highest.beyond[place], at[place], amounts)
                )
                write_law(file, folder / f"law_{place}.json")
                clamps.append(source.model_copy(update={"law": str(folder / f"law_{place}.json")}))
            changed = self.description.model_copy(update={"clamps": tuple(clamps)})
            where = f"{self.path}, at an end of its band"
            system = steady_system(
                changed, self.pipe, self.path.parent, curve.temperature, curve.level, self.table.harmonics, where
            )
            if apart:
                found_curve = curve_of(system, self.table, curve.temperature, curve.level, where)
            else:
                followed = system.followed(self.table.from_Hz, self.table.to_Hz)
                found_curve = Curve(curve.temperature, curve.level, followed)
            if not found_curve.pieces or found_curve.followed.in_time:
                raise UserError(f"{where}: no motion is balanced from end to end of the frequencies")
            return found_curve
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def moving_of(
    system: SteadySystem, clamps: Sequence[SteadyClamp], pieces: Sequence[Sequence[SteadyState]], unknown: Unknown
) -> list[list[Moving]]:
    """Give, for each clamp and probe, the pieces of a curve with how they move; arguments as of `moves`."""
    moved = [[moves(system, clamps, state, unknown) for state in piece] for piece in pieces]
    points = len(amplitudes_of(pieces[0][0]))
    return [
        [
            Moving(
                np.array([state.frequency for state in piece]),
                np.array([amplitudes_of(state)[point] for state in piece]),
                np.stack([one.frequency for one in own], axis=1),
                np.stack([one.amplitudes[:, point] for one in own], axis=1),
                np.stack([one.turning for one in own], axis=1),
            )
            for piece, own in zip(pieces, moved, strict=True)
        ]
        for point in range(points)
    ]


def _peak_of(curve: Curve, point: int) -> float:
    """Give the amplitude of a curve's peak at a point, mm."""
    tops = []
    for piece in curve.pieces:
        values = np.array([amplitudes_of(state)[point] for state in piece])
        nothing = np.zeros((0, len(piece)))
        tops.append(Moving(values, values, nothing, nothing, nothing).peak()[1])
    return max(tops)


def _followed(
    peak: PeakBand, middle: float | None, ends: Sequence[float | None], foretold: Sequence[float]
) -> PeakBand:
    """Bend the band of a peak as the peaks that were solved at both ends bend.

    Args:
        peak: to first order.
        middle: amplitude as solved in the middle of the band; None where none was found.
        ends: amplitude as solved at the low and the high end of the first point's band; None where none was found.
        foretold: steps of the amplitude from the middle to there, to first order.
    """
    amplitude = peak.amplitude
    sides = []
    for solved, step, end in zip(ends, foretold, (amplitude.low, amplitude.high), strict=True):
        # a point that hardly moves there tells nothing of its own band
        told = solved is not None and abs(step) >= TELLING_SHARE * abs(end - amplitude.middle) > 0
        bend = (solved - middle) / step if solved is not None and middle is not None and told else 1.0
        sides.append(bend if bend > 0 else 1.0)
    at = amplitude.middle if middle is None else middle
    low = at + sides[0] * (amplitude.low - amplitude.middle)
    high = at + sides[1] * (amplitude.high - amplitude.middle)
    return replace(peak, amplitude=replace(amplitude, low=low, high=high, middle=at))
