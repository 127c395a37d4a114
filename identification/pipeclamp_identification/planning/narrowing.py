"""From the pipe back to the test: which loop test narrows the band of the pipe's peak most."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pipeclamp_identification.diagnosis.further_test.limits import Limits
from pipeclamp_identification.planning.band_plan import BandPlan
from pipeclamp_identification.planning.loop_tests import LoopTests, noise_words
from pipeclamp_identification.planning.narrowing_search import NarrowingSearch, tests_of_clamp, wanted_peak
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.toml_file import unknown as unknown_name
from pipeclamp_system.bands.described import unknown_of
from pipeclamp_system.bands.response import banded_system
from pipeclamp_system.bands.response import refuse as refuse_bands
from pipeclamp_system.bands.varied import gaps
from pipeclamp_system.response.curves import label
from pipeclamp_system.response.run import run_response
from pipeclamp_system.steady.described import read_responding, steady_clamps


def plan_tests(
    path: Path,
    limits: Limits | None = None,
    *,
    per_cent: float = 95.0,
    at: str | None = None,
    noise_N: float | None = None,
    progress: Progress = silent,
) -> BandPlan:
    """Give the loop tests that narrow the band of a pipe's peak most, one after another.

    A test is a linear measurement of the law's parameters, and of what the law's form is off there: with their
    covariance it leaves a smaller one. How much it tells of the form where the pipe moves, kriging says. What a
    mounting scatters stays.

    Args:
        path: SYSTEM.toml.
        limits: what the rig can do; where nothing is stated, around what the law was tested at.
        per_cent: that bands hold.
        at: clamp or probe; that of the widest band beside its peak unless told.
        noise_N: rms noise of the force; None for that of the law's tests.
        progress: told what is being done.

    Raises:
        UserError: the system can't be read or solved, no law tells how sure it is, or the rig can drive no test.
        UsageError: the share can't be held by a band, or there is no such clamp or probe.
    """
    refuse_bands(path, per_cent, {})
    _refuse_beforehand(path, limits, at, noise_N)
    response = run_response(path, progress, dots=False)
    system = banded_system(path, response, by_clamp=True)
    points = range(len(response.points)) if at is None else [response.points.index(at)]
    progress("what the peaks follow")
    every = [wanted_peak(system, curve, point) for curve in response.curves for point in points]
    wanted = max(every, key=lambda one: one.deviation(system.unknown.covariance) / one.amplitude)
    progress("the band as it is")
    before = system.bands(wanted.curve, per_cent).peaks[wanted.point]
    search = NarrowingSearch(path, system, wanted, before, per_cent, response.clamp_names)
    fields = [search.tests_of(law, limits, noise_N) for law in dict.fromkeys(system.unknown.laws)]
    _refuse_none(fields)
    progress("tests that would narrow it")
    known = [field for field, _ in fields]
    files = {field.law: field.law.file for field in known}
    noises = {file.name: noise_words(file, noise_N) for file in files.values()}
    return BandPlan(
        response.name, label(wanted.curve.temperature, wanted.curve.level), response.points[wanted.point], per_cent,
        before, tuple(search.one_after_another(known)), search.floor(known),
        tuple(search.map_of(field) for field in known if len(field)),
        {field.law.file.name: words for field, words in fields}, noises, gaps(system.unknown.laws),
    )  # fmt: skip


def _refuse_beforehand(path: Path, limits: Limits | None, at: str | None, noise_N: float | None) -> None:
    """Refuse a point that the system hasn't, and limits that no test keeps, before its response is computed."""
    system, where = read_responding(path), str(path)
    points = [*(clamp.at for clamp in system.description.clamps), *system.pipe.probe_names]
    if at is not None and at not in points:
        raise UsageError(f"--at: {unknown_name(at, points, 'clamp or probe')}")
    laws = unknown_of(system.description, path.parent).laws
    fields = []
    for temperature in system.table.temperatures_C or (None,):
        clamps = steady_clamps(system.description, system.pipe, path.parent, temperature, where)
        fields += [
            tests_of_clamp(law, clamps[laws.index(law)][1], limits, None, noise_N) for law in dict.fromkeys(laws)
        ]
    _refuse_none(fields)


def _refuse_none(fields: Sequence[tuple[LoopTests, str]]) -> None:
    """Refuse limits, in words, within which there is no test of any law."""
    if not any(len(field) for field, _ in fields):
        said = "; ".join(dict.fromkeys(words for _, words in fields))
        raise UsageError(f"--limits: no sine test keeps all of {said}; expected wider limits")
