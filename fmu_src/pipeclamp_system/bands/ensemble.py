"""A run in time with its bands: an ensemble of runs whose laws differ as their tests allow."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path

import numpy as np

from pipeclamp_fmu.slaves.clamp import MM
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import cores, spread
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import LawFile, write_law
from pipeclamp_models.law.range import as_in_range, conditions_beyond, conditions_inside
from pipeclamp_system.bands.band import Band, band_of, beside_words, ends_words, origin_words, steps_of
from pipeclamp_system.bands.quantities import Unknown, even_normal, unknown_of_clamps
from pipeclamp_system.bands.varied import gaps, refuse_silent, varied
from pipeclamp_system.cosim.building import TO_RUN_IN_DOUBT, law_in
from pipeclamp_system.cosim.law_conditions import further_conditions
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.run import run_described
from pipeclamp_system.description.system import SystemDescription, read_system

FEWEST_MEMBERS = 32
"""Members of an ensemble at least; two for each thing that isn't known."""
MOST_FAILED = 0.1
"""Share of the members that may fail."""
BENDS = 0.1
"""Share of a band's variance that its linear part doesn't explain, from which on that is said."""


@dataclass(frozen=True)
class BandedValue:
    """What is read off a run at one place, with its band.

    Attributes:
        name: of the clamp or probe; of a force, with the word.
        unit: mm or N.
        band: the number.
        bent: share of the ensemble's variance that doesn't follow what isn't known in proportion.
    """

    name: str
    unit: str
    band: Band
    bent: float


@dataclass(frozen=True, eq=False)
class RunBands:
    """A run in time with its bands.

    Attributes:
        result: the run, with the ends of the bands among its columns.
        per_cent: that each band holds.
        values: amplitudes over the last fifth of a run under a sine; else the largest displacements and forces.
        members: runs of the ensemble, and how many failed.
        gaps: what the laws' files don't tell, in words.
    """

    result: CosimResult
    per_cent: float
    values: tuple[BandedValue, ...]
    members: int
    failed: int
    gaps: tuple[str, ...]

    def words(self) -> list[str]:
        """Say how sure the run is."""
        what = "amplitude over the last fifth" if self.result.settles else "largest"
        lines = [
            f"{one.name}: {what} {ends_words(one.band, one.unit, self.per_cent)}{beside_words(one.band)}"
            + (f"; {one.bent:.0%} of its variance isn't in proportion to what isn't known" if one.bent > BENDS else "")
            for one in self.values
        ]
        failed = f", of which {self.failed} failed and don't count" if self.failed else ""
        widest = max(self.values, key=lambda one: one.band.deviation / one.band.value)
        lines += origin_words(widest.name, widest.band)
        return [*lines, f"bands of {self.members} runs with other laws{failed}", *self.gaps]


@dataclass(frozen=True)
class _Member:
    """One run of an ensemble: the system with the laws of its own, in files."""

    description: SystemDescription
    folder: Path
    where: str
    columns: tuple[str, ...]
    time: Array


def run_bands(path: Path, result: CosimResult, per_cent: float, progress: Progress = silent) -> RunBands:
    """Give a run's bands by an ensemble on all cores.

    Args:
        path: SYSTEM.toml, that the run is of.
        result: the run.
        per_cent: that each band holds, such as 95.
        progress: told what is being done.

    Raises:
        UserError: no clamp has a law whose uncertainty is known, or more than a tenth of the runs fail.
        UsageError: the share can't be held by a band.
    """
    steps = steps_of(per_cent)
    description = read_system(path)
    places, what = _unknown_of(description, path)
    names = [description.clamps[place].at for place in places]
    roots = what.roots()
    drawn = even_normal(max(FEWEST_MEMBERS, 2 * roots.shape[1]), roots.shape[1])
    points = [*result.clamp_names, *result.probe_names]
    columns = (*(f"{name}.s" for name in points), *(f"{name}.f" for name in names))
    at = [
        as_in_range(law.file, _conditions(result, place, law.file, str(path)))
        for place, law in zip(places, what.laws, strict=True)
    ]
    beyond = [conditions_beyond(law.file, one) for law, one in zip(what.laws, at, strict=True)]
    inside = [conditions_inside(law.file.range, one) for law, one in zip(what.laws, at, strict=True)]
    folder = Path(tempfile.mkdtemp(prefix="pipeclamp_"))
    try:
        jobs = []
        for number, row in enumerate(drawn @ roots.T + what.means):
            clamps = list(description.clamps)
            for index, place in enumerate(places):
                file = folder / f"law_{number}_{index}.json"
                write_law(what.laws[index].with_changes(what.changes(index, beyond[index], inside[index], row)), file)
                clamps[place] = clamps[place].model_copy(update={"law": str(file)})
            changed = description.model_copy(update={"clamps": tuple(clamps)})
            jobs.append(_Member(changed, path.parent, str(path), columns, result.time))
        found = []
        for run in spread(_run, jobs, cores()):
            found.append(run)
            progress(f"run {len(found)} of {len(jobs)} of the ensemble")
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    good = [place for place, run in enumerate(found) if not isinstance(run, str)]
    if len(found) - len(good) > MOST_FAILED * len(found):
        first = next(run for run in found if isinstance(run, str))
        raise UserError(f"{len(found) - len(good)} of the band's {len(found)} runs failed, the first one so: {first}")
    histories = np.stack([run for run in found if not isinstance(run, str)])
    banded = _with_bands(result, columns, histories, steps, moved=bool(what.means.any()))
    values = _banded_values(result, columns, histories, drawn[good], roots, what, steps)
    return RunBands(banded, per_cent, values, len(found), len(found) - len(good), gaps(what.laws))


def refuse(path: Path, per_cent: float) -> None:
    """Refuse what no band can be given of, before anything is computed.

    Raises:
        UserError: the system can't be read, or no clamp has a law whose uncertainty is known.
        UsageError: the share can't be held by a band.
    """
    steps_of(per_cent)
    _unknown_of(read_system(path), path)


def _unknown_of(description: SystemDescription, path: Path) -> tuple[list[int], Unknown]:
    """Give which clamps have a law, and what isn't known of them.

    Raises:
        UserError: nothing is.
    """
    places = [place for place, clamp in enumerate(description.clamps) if clamp.law is not None]
    sources = [str(description.clamps[place].law) for place in places]
    known = {name: varied(law_in(path.parent, name)) for name in dict.fromkeys(sources)}
    names = [description.clamps[place].at for place in places]
    refuse_silent(known.values(), str(path))
    return places, unknown_of_clamps([known[name] for name in sources], names, solved=False)


def _run(member: _Member) -> Array | str:
    """Give the columns of a member's run at the nominal run's times, (columns, n); what failed where it does."""
    try:
        result = run_described(member.description, member.folder, member.where, checked=False, build=TO_RUN_IN_DOUBT)
    except UserError as error:
        return str(error)
    return np.stack([np.interp(member.time, result.time, result.columns[name]) for name in member.columns])


def _conditions(result: CosimResult, place: int, file: LawFile, where: str) -> dict[str, float]:
    """Give the conditions of a clamp's run: A (mm), f (Hz), T (K) and further ones that its law follows."""
    source = result.system.clamps[place]
    values = {
        "A": MM * float(np.ptp(result.columns[f"{source.at}.s"])) / 2,
        "f": float(result.columns[f"{source.at}.f_used"][-1]),
        "T": source.temperature_C + CELSIUS,
        **further_conditions(file, source, where),
    }
    return {name: value for name, value in values.items() if isfinite(value)}


def _with_bands(
    result: CosimResult, columns: Sequence[str], histories: Array, steps: float, *, moved: bool
) -> CosimResult:
    """Give the run with the ends of the bands as further columns; about the ensemble's mean where tests move it."""
    ends: dict[str, Array] = {}
    units: dict[str, str] = {}
    for place, name in enumerate(columns):
        half = steps * np.std(histories[:, place], axis=0, ddof=1)
        middle = np.mean(histories[:, place], axis=0) if moved else result.columns[name]
        for end, values in (("low", middle - half), ("high", middle + half)):
            ends[f"{name}_{end}"], units[f"{name}_{end}"] = values, result.units[name]
    return replace(result, columns={**result.columns, **ends}, units={**result.units, **units})


def _banded_values(
    result: CosimResult, columns: Sequence[str], histories: Array, drawn: Array, roots: Array, what: Unknown,
    steps: float,
) -> tuple[BandedValue, ...]:  # fmt: skip
    """Give what is read off the run with its bands, by what it follows in proportion."""
    sizes: Mapping[str, float] = {".s": MM, ".f": 1.0}
    design = np.column_stack([np.ones(len(drawn)), drawn])
    banded = []
    for place, column in enumerate(columns):
        name, kind = column[:-2], column[-2:]
        values = np.array([_read(result, column, one[place]) for one in histories]) * sizes[kind]
        line = np.linalg.lstsq(design, values, rcond=None)[0]
        begin, *slopes = line
        free = len(values) - design.shape[1]
        rest = float(np.sum((values - design @ line) ** 2)) / max(free, 1)
        value = _read(result, column, result.columns[column]) * sizes[kind]
        error = result.step_error
        solution = value * error if kind == ".s" and error is not None and isfinite(error) else 0.0
        by_quantity = np.linalg.pinv(roots.T) @ np.array(slopes)
        moved = float(begin) - value if what.means.any() else 0.0
        band = band_of(value, by_quantity, what, steps, float(np.hypot(solution, np.sqrt(rest))), moved)
        bent = rest / band.deviation**2 if band.deviation > 0 else 0.0
        words, unit = (name, "mm") if kind == ".s" else (f"force of {name}", "N")
        banded.append(BandedValue(words, unit, band, bent))
    return tuple(banded)


def _read(result: CosimResult, column: str, values: Array) -> float:
    """Read a column: the amplitude over the last fifth of a run under a sine, else the largest size."""
    if result.settles:
        return replace(result, columns={**result.columns, column: values}).amplitude(column)
    return float(np.abs(values).max())
