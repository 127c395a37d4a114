"""Identification: a law fitted to all runs of a campaign at once, with everything its parameter file states."""

from __future__ import annotations

import importlib.metadata
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.campaign.seen import LeftOut
from pipeclamp_identification.fitting.group_factors import PooledObservations
from pipeclamp_identification.fitting.groups import factors_of, find_groups, has_groups
from pipeclamp_identification.fitting.groups_answer import groups_answer
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.joint.not_fitted import OF_THE_LAW
from pipeclamp_identification.fitting.least_squares import FIT_TOLERANCE, fit, unfitted
from pipeclamp_identification.fitting.misfit import RunMisfit, known_noise, misfits, overall_nrmse
from pipeclamp_identification.fitting.observations import LoopObservations, coarser, loop_observations
from pipeclamp_identification.fitting.spread import spread_of
from pipeclamp_identification.fitting.surfaces import elastic_values, surface_values
from pipeclamp_identification.loops.loops import PRELOADED, Loops, by_stretch, loops_of
from pipeclamp_models.base.answer import left_out_runs
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.toml_file import unknown
from pipeclamp_models.law.file import (
    SCHEMA,
    CoefficientEntry,
    CoefficientState,
    Correlation,
    Covariance,
    DataSource,
    Estimate,
    FitQuality,
    GroupEntry,
    HistoryStep,
    Interval,
    LawFile,
    Prior,
    Provenance,
    RunQuality,
)
from pipeclamp_models.law.law import BASE_LAW, Structure
from pipeclamp_models.law.outline import ParameterOutline
from pipeclamp_models.law.range import intervals_of, rounded
from pipeclamp_models.realise.force import LawForce
from pipeclamp_models.realise.sizes import about

Method = Literal["joint", "surfaces"]

FIRST_TOLERANCE = 1e-5
"""Tolerance of the fits that only serve to see what the law leaves over, and to come near."""
ANOTHER_VALLEY = 2.0
"""Deviance by which a fit is likelier than another, what Akaike's criterion asks for a parameter more; by less both may
have come to the same place."""


@dataclass(frozen=True)
class Identification:
    """A law identified from a campaign.

    Attributes:
        fit: the fit.
        loops: the campaign's loops.
        observations: the same, as observations.
        misfits: its error on each run.
        method: how it was found.
    """

    fit: Fit
    loops: Loops
    observations: LoopObservations
    misfits: tuple[RunMisfit, ...]
    method: Method


def identify(
    campaign: Campaign,
    structure: Structure = BASE_LAW,
    *,
    method: Method = "joint",
    progress: Progress = silent,
) -> Identification:
    """Identify a law from all runs of a campaign.

    Args:
        campaign: the tests.
        structure: of the law; base "series" chooses its orders by their accuracy on left-out conditions.
        method: "joint" fits everything at once; "surfaces" is the paper's route by itself, loop by loop and then
            surfaces over the conditions (power base without effects).
        progress: is told what is being done.

    Raises:
        UserError: an unknown base or effect, data that can't determine the law, or no temperature where it's needed.
    """
    progress(f"loops of {len(campaign.runs)} runs")
    loops = loops_of(campaign)
    observations = loop_observations(loops)
    if structure.base == "series":
        # Its highest orders stand with the mathematics of its terms, which other bases do without.
        from pipeclamp_identification.fitting.series_orders import choose_series

        progress("orders of the series")
        structure = replace(choose_series(loops, observations, replace(structure, frozen=())), frozen=structure.frozen)
    refuse_held(structure)
    result = fit_structure(structure, loops, observations, method=method, progress=progress)
    progress("error on every sample")
    return Identification(result, loops, observations, misfits(result.law, campaign, loops), method)


def refuse_held(structure: Structure) -> None:
    """Refuse to hold parameters that the law doesn't have, or where no fit may take them.

    Raises:
        UsageError: one is so.
    """
    outlines = {outline.name: outline for outline in structure.equations.parameters}
    for name, value in structure.frozen:
        if name not in outlines:
            raise UsageError(f"--freeze: {unknown(name, list(outlines), 'parameter')}")
        # bounds in sizes of the data, which are texts, are a fit's own
        bounds = (outlines[name].lower, outlines[name].upper)
        low, high = (math.nan if isinstance(bound, str) else float(bound) for bound in bounds)
        if value < low or value > high:
            expected = f"at least {low:g}" if value < low else f"at most {high:g}"
            raise UsageError(f"--freeze: got {name}={value:g}; expected {expected}, where a fit may take it")


def fit_structure(
    structure: Structure,
    loops: Loops,
    observations: LoopObservations | None = None,
    *,
    start: Mapping[str, float] | None = None,
    method: Method = "joint",
    tolerance: float = FIT_TOLERANCE,
    progress: Progress = silent,
) -> Fit:
    """Fit a structure to loops: weighted by their scatter first, then by scatter and what the law leaves over.

    Effects that change from cycle to cycle are fitted to stretches of each record. Laws with states are led near at
    fewer points of the cycle. From values that are known the fit begins twice, weighted by scatter and by what the law
    leaves over there, and goes on from where the tests are likelier.

    Raises:
        UserError: the data can't serve the structure.
    """
    if method not in get_args(Method):
        raise UsageError(f"--method: got {method!r}; expected {' or '.join(get_args(Method))}")
    equations = structure.equations
    if equations.ages and len((parted := by_stretch(loops)).run) > len(loops.run):
        loops, observations = parted, None
    observations = observations or loop_observations(loops)
    from_surfaces = surface_values(structure, loops)
    if method == "surfaces":
        if not from_surfaces or structure.effects:
            raise UsageError(
                f"method surfaces: got base {structure.base!r} with effects {list(structure.effects)}; "
                "expected base power or memory without effects (the joint method fits the others)"
            )
        return unfitted(structure, observations, from_surfaces)
    progress(f"fit of {len(equations.parameters)} parameters to {len(loops.run)} loops")
    # With elements that slip, the loop's area isn't the power's alone: only the elastic surfaces are a fair start then.
    fair = elastic_values(from_surfaces) if equations.states else from_surfaces
    begin = {**fair, **(start or {})}
    if has_groups(loops) and set(equations.names) <= set(begin):
        as_begun = unfitted(structure, observations, begin).law_force
        beside = _fit_beside_groups(structure, loops, observations, as_begun, begin, progress, tolerance)
        if beside is not None:
            return beside
    rough = coarser(loops, observations) if equations.states else observations
    first = fit(structure, rough, start=begin, tolerance=FIRST_TOLERANCE, progress=progress)
    if has_groups(loops):
        found_near = unfitted(structure, observations, first.law.values) if equations.states else first
        beside = _fit_beside_groups(structure, loops, observations, found_near.law_force, begin, progress, tolerance)
        if beside is not None:
            return beside
    if equations.states or start:
        near = fit(
            structure, rough.with_discrepancy(first.law_force), start=first.law.values, tolerance=FIRST_TOLERANCE
        )
        if start:
            # Weights of scatter alone may have led a law that is known out of its valley into a poorer one.
            as_known = rough.with_discrepancy(unfitted(structure, rough, begin).law_force)
            from_there = fit(structure, as_known, start=begin, tolerance=FIRST_TOLERANCE, progress=progress)
            if rough.deviance(near.law_force) - rough.deviance(from_there.law_force) > ANOTHER_VALLEY:
                first = near = from_there
        if equations.states:
            first = unfitted(structure, observations, near.law.values)
    widened = observations.with_discrepancy(first.law_force)
    result = fit(structure, widened, start=first.law.values, tolerance=tolerance, progress=progress)
    found = find_groups(loops, observations, result.law_force)
    return replace(result, groups=found) if found else result


def _fit_beside_groups(
    structure: Structure,
    loops: Loops,
    observations: LoopObservations,
    law_force: LawForce,
    begin: Mapping[str, float],
    tell: Progress,
    closely: float,
) -> Fit | None:
    """Fit a structure beside random factors of groups, and these again beside the fit; None where groups don't differ.

    Args:
        structure: what is fitted.
        loops, observations: the tests.
        law_force: of a law that shows whether groups differ.
        begin: where the fit begins: what groups do to a fit without them mustn't lead it astray.
        tell: is told what is being done.
        closely: tolerance of the last fit.
    """
    factors = factors_of(find_groups(loops, observations, law_force), loops, observations)
    if factors is None:
        return None
    tell("fit beside the factors of groups")
    start = begin
    for tolerance in (FIRST_TOLERANCE, closely):
        widened = observations.with_discrepancy(law_force, factors.beside(law_force).force())
        pooled = PooledObservations(widened, factors)
        result = fit(structure, pooled, start=start, tolerance=tolerance, progress=tell)
        law_force, start = result.law_force, result.law.values
        found = find_groups(loops, observations, law_force)
        again = factors_of(found, loops, observations)
        if again is None:
            # beside a better law they don't differ
            return None
        factors = again
    return replace(result, groups=found)


def law_file(
    identification: Identification,
    campaign: Campaign,
    *,
    name: str,
    provenance: Provenance,
) -> LawFile:
    """Give the parameter file of an identified law.

    Args:
        identification: what was found.
        campaign: the tests it was found from.
        name: name of the law.
        provenance: how the file comes about.
    """
    runs = identification.misfits
    quality = FitQuality(
        method=identification.method,
        nrmse=rounded(overall_nrmse(runs)),
        noise_nrmse=_rounded(known_noise(runs, identification.loops)),
        mean_share=rounded(mean) if (mean := identification.loops.mean_share) > PRELOADED else None,
        runs=tuple(
            RunQuality(run=run.run, nrmse=rounded(run.nrmse), noise_nrmse=rounded(run.noise_nrmse) if many else None)
            for run, many in zip(runs, identification.loops.shows_scatter, strict=True)
        ),
        unsettled=int(np.count_nonzero(identification.fit.law_force.unsettled)) or None,
    )
    data = data_source(
        campaign.name, campaign.fingerprint, len(campaign.runs), campaign.left_out,
        time_measured=campaign.time_measured, about_mm=about(identification.observations.motion),
    )  # fmt: skip
    covered = range_of(identification.loops, aged=identification.fit.equations.ages)
    file = file_of_fit(identification.fit, covered, data, quality, name=name, provenance=provenance)
    spread = spread_of(identification.fit, identification.loops, identification.observations)
    return file.model_copy(update={"spread": spread})


def _rounded(value: float | None) -> float | None:
    return None if value is None else rounded(value)


def data_source(
    name: str,
    fingerprint: str,
    runs_used: int,
    left_out: Iterable[LeftOut],
    *,
    time_measured: bool,
    about_mm: float = 0.0,
) -> DataSource:
    """Give what a parameter file says of the data that its law was identified from."""
    return DataSource(
        name=name,
        fingerprint=fingerprint,
        runs_used=runs_used,
        left_out=left_out_runs(left_out),
        time_measured=None if time_measured else False,
        about_mm=rounded(about_mm) or None,
    )


def file_of_fit(
    result: Fit,
    range: Mapping[str, Interval],
    data: DataSource,
    quality: FitQuality,
    *,
    name: str,
    provenance: Provenance,
) -> LawFile:
    """Give the parameter file of a fit, whatever it was fitted to.

    Args:
        result: the fit.
        range: of the conditions that the data cover.
        data: where it comes from.
        quality: how well the law fits it.
        name: name of the law.
        provenance: how the file comes about.
    """
    order = np.argsort(np.array(result.fitted))
    names = tuple(result.fitted[index] for index in order)
    matrix = result.covariance[np.ix_(order, order)]
    structure = result.law.structure
    step = HistoryStep(step=" + ".join((structure.base, *structure.effects)), nrmse=quality.nrmse)
    return LawFile(
        schema=SCHEMA,
        name=name,
        base=structure.base,
        effects=structure.effects,
        declared=tuple(entry for entry in structure.declared if entry.id in structure.effects),
        smoothing={"v_r": rounded(result.law.v_r), "y_r": rounded(result.law.y_r)},
        coefficients=coefficient_entries(result),
        covariance=Covariance(names=names, matrix=tuple(tuple(rounded(entry) for entry in row) for row in matrix)),
        correlations=tuple(
            Correlation(pair=(one, other), value=round(value, 4)) for one, other, value in result.strong_correlations()
        ),
        range=dict(range),
        data=data,
        fit=quality,
        groups=_group_entries(result) or None,
        history=(step,),
        software=software(),
        command=provenance.command,
        date=provenance.date,
    )


def _group_entries(result: Fit) -> tuple[GroupEntry, ...]:
    """Give the file's entries of groups of runs that differ."""
    entries = []
    for one in groups_answer([found for found in result.groups if found.differ]):
        for group in one.groups:
            factors = {
                name: Estimate(value=rounded(estimate.value), standard_error=rounded(estimate.standard_error))
                for name in ("stiffness_factor", "damping_factor", "mean_force_N")
                if (estimate := getattr(group, name)) is not None
            }
            entries.append(GroupEntry(column=one.column, name=group.name, runs=group.runs, **factors))
    return tuple(entries)


def coefficient_entries(result: Fit) -> dict[str, CoefficientEntry]:
    """Give the file's entry of each parameter: value, standard error, and how it came about."""
    errors = result.standard_errors()
    entries = {}
    for parameter in result.equations.parameters:
        name = parameter.name
        if name in result.frozen:
            state: CoefficientState = "held" if result.frozen[name] in OF_THE_LAW else "frozen"
        elif name in result.at_bound:
            state = "at_bound"
        else:
            state = "fitted"
        entries[name] = CoefficientEntry(
            value=rounded(result.law.values[name]),
            unit=parameter.unit,
            standard_error=rounded(errors[name]) if name in errors else None,
            state=state,
            meaning=parameter.meaning,
            reason=result.frozen.get(name, ""),
            prior=_prior(parameter, result.spreads.get(name)) if state != "held" else None,
        )
    return entries


def _prior(parameter: ParameterOutline, spread: float | None) -> Prior | None:
    return None if spread is None else Prior(mean=parameter.neutral or 0.0, standard_deviation=rounded(spread))


def range_of(loops: Loops, *, aged: bool = False) -> dict[str, Interval]:
    """Give the range of conditions that the loops cover; conditions that aren't known are left out.

    Args:
        loops: the tests.
        aged: whether the load cycles belong to it.
    """
    slow = {
        "A": loops.amplitude_mm,
        "f": loops.frequency_Hz,
        "T": loops.temperature_K,
        "rho": loops.density_g_cm3,
    }
    cycles = {"N": np.concatenate(loops.cycles)} if aged else {}
    return intervals_of({**slow, **cycles, **loops.conditions})


def software() -> str:
    """Give the program's name and version."""
    return f"pipeclamp {importlib.metadata.version('pipeclamp')}"
