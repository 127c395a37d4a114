"""Add an effect to a law: refit everything, and say what the error did."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial

from pipeclamp.declaration import Declaration
from pipeclamp.effect import Effect
from pipeclamp.errors import UserError
from pipeclamp.law import Structure, compose
from pipeclamp.parameter_file import HistoryStep, LawFile, law_of, structure_of
from pipeclamp_identification.campaign import Campaign
from pipeclamp_identification.fit import Progress, fit
from pipeclamp_identification.heldout import heldout_nrmse
from pipeclamp_identification.identify import Identification, fit_structure, law_file
from pipeclamp_identification.law_range import rounded
from pipeclamp_identification.loops import loops_of
from pipeclamp_identification.metric_campaign import SCATTER, MetricCampaign, metric_observations
from pipeclamp_identification.metric_evidence import heldout_error
from pipeclamp_identification.metric_law import compare_metrics, metric_law_file, rms
from pipeclamp_identification.misfit import known_noise, misfits, overall_nrmse
from pipeclamp_identification.observations import loop_observations
from pipeclamp_identification.report import Table


@dataclass(frozen=True)
class Addition:
    """What adding an effect did.

    Attributes:
        effect: what was changed: + or - and the effect's name.
        before, after: the law's file before, and the one with the effect.
        nrmse: error on the campaign before and after, as a share of the force.
        heldout: error on left-out groups of conditions before and after.
        noise_nrmse: the scatter that no law can explain; None where it isn't known.
    """

    effect: str
    before: LawFile
    after: LawFile
    nrmse: tuple[float, float]
    heldout: tuple[float, float]
    noise_nrmse: float | None


def add_effect(
    file: LawFile,
    effect: str,
    campaign: Campaign | MetricCampaign,
    *,
    command: str,
    date: str | None,
    declared: Iterable[Declaration] = (),
    progress: Progress | None = None,
) -> Addition:
    """Add an effect to a law and refit everything to a campaign.

    Args:
        file: the law.
        effect: name of the effect.
        campaign: the tests to refit to.
        declared: a user's own effects.
        command: the command that makes the new file again.
        date: when it is made; None leaves the line out.
        progress: is told what is being done.

    Raises:
        UserError: the effect isn't known or is there already, or the data can't serve it.
    """
    new = with_effect(structure_of(file).with_declared(declared), effect)
    return _changed(file, new, f"+ {effect}", campaign, command=command, date=date, progress=progress)


def remove_effect(
    file: LawFile,
    effect: str,
    campaign: Campaign | MetricCampaign,
    *,
    command: str,
    date: str | None,
    progress: Progress | None = None,
) -> Addition:
    """Take an effect out of a law and refit the rest to a campaign; arguments as for `add_effect`.

    Raises:
        UserError: the law hasn't got the effect.
    """
    old = structure_of(file)
    if effect not in old.effects:
        raise UserError(f"effect {effect!r} isn't in the law; it has {', '.join(old.effects) or 'no effects'}")
    new = replace(old, effects=tuple(name for name in old.effects if name != effect))
    return _changed(file, new, f"- {effect}", campaign, command=command, date=date, progress=progress)


def _changed(
    file: LawFile,
    new: Structure,
    step: str,
    campaign: Campaign | MetricCampaign,
    *,
    command: str,
    date: str | None,
    progress: Progress | None,
) -> Addition:
    """Refit a law with another structure and state the error before and after."""
    tell = progress or (lambda _: None)
    refit = partial(_refit_metrics, campaign) if isinstance(campaign, MetricCampaign) else partial(_refit, campaign)
    done = refit(file, new, _shared_values(law_of(file).values, new), tell)
    after = done.file(name=file.name, command=command, date=date)
    history = file.history or (HistoryStep(step=file.name, nrmse=rounded(done.nrmse[0])),)
    history = (*history[:-1], history[-1].model_copy(update={"heldout_nrmse": rounded(done.heldout[0])}))
    last = HistoryStep(step=step, nrmse=rounded(done.nrmse[1]), heldout_nrmse=rounded(done.heldout[1]))
    after = after.model_copy(update={"history": (*history, last), "notes": file.notes})
    return Addition(step, file, after, done.nrmse, done.heldout, done.noise_nrmse)


@dataclass(frozen=True)
class _Refitted:
    """A law refitted with another structure: what makes its file, and errors before and after, as in `Addition`."""

    file: Callable[..., LawFile]
    nrmse: tuple[float, float]
    heldout: tuple[float, float]
    noise_nrmse: float | None


def _refit(campaign: Campaign, file: LawFile, new: Structure, start: Mapping[str, float], tell: Progress) -> _Refitted:
    """Refit to records."""
    law = law_of(file)
    loops = loops_of(campaign)
    observations = loop_observations(loops)
    tell("error of the law as it is")
    before = overall_nrmse(misfits(law, campaign, loops))
    tell("refit")
    result = fit_structure(new, loops, observations, start=start, progress=tell)
    runs = misfits(result.law, campaign, loops)
    tell("error on left-out conditions")
    heldout = (
        heldout_nrmse(law, loops, observations),
        heldout_nrmse(result.law, loops, observations),
    )
    identification = Identification(result, loops, runs, "joint")
    return _Refitted(
        partial(law_file, identification, campaign), (before, overall_nrmse(runs)), heldout, known_noise(runs, loops)
    )


def _refit_metrics(
    campaign: MetricCampaign, file: LawFile, new: Structure, start: Mapping[str, float], tell: Progress
) -> _Refitted:
    """Refit to metrics; errors are rms log ratios, and the scatter is the one that was expected."""
    law = law_of(file)
    observations = metric_observations(campaign)
    before = compare_metrics(file, campaign).nrmse
    tell("refit")
    result = fit(new, observations, start=start, progress=tell)
    tell("error on left-out conditions")
    heldout = (
        heldout_error(law.structure, observations, law.values),
        heldout_error(new, observations, result.law.values),
    )
    after = rms(observations.logs(result.response.force))
    return _Refitted(partial(metric_law_file, result, campaign), (before, after), heldout, SCATTER)


def with_effect(structure: Structure, effect: str) -> Structure:
    """Give the structure with one more effect; a family's effect takes the place of a smaller one of its kind.

    Raises:
        UserError: the effect is there already, or it is part of the base law.
    """
    added = structure.effect(effect)
    if added.part == "base":
        raise UserError(f"effect {effect!r} is a term of base laws; choose a base with identify --base")
    if added.name in {present.name for present in structure.all_effects()}:
        present = " + ".join((structure.base, *structure.effects))
        raise UserError(f"effect {effect!r} is in the law already: {present}; expected another one")
    kept = tuple(name for name in structure.effects if not _replaces(added, structure.effect(name)))
    return replace(structure, effects=(*kept, effect))


def _replaces(added: Effect, present: Effect) -> bool:
    """Tell whether an added effect is the present one with another argument, sharing its symbols."""
    own = {parameter.symbol for parameter in added.parameters} | {state.symbol for state in added.states}
    other = {parameter.symbol for parameter in present.parameters} | {state.symbol for state in present.states}
    return added.id == present.id and bool(own & other)


def _shared_values(values: Mapping[str, float], structure: Structure) -> dict[str, float]:
    """Give the values of those parameters that both laws have."""
    names = set(compose(structure).names)
    return {name: value for name, value in values.items() if name in names}


def addition_table(addition: Addition) -> Table:
    """Give what adding the effect did to the error and to the parameters."""
    scatter = None if addition.noise_nrmse is None else 100 * addition.noise_nrmse
    rows: list[tuple[str, float | None, float | None]] = [
        ("error on the runs used / %", 100 * addition.nrmse[0], 100 * addition.nrmse[1]),
        ("error on left-out conditions / %", 100 * addition.heldout[0], 100 * addition.heldout[1]),
        ("scatter that no law explains / %", scatter, scatter),
    ]
    before, after = addition.before.coefficients, addition.after.coefficients
    for name in dict.fromkeys((*before, *after)):
        unit = (after.get(name) or before[name]).unit
        values = (before[name].value if name in before else None, after[name].value if name in after else None)
        rows.append((f"{name} / {unit}", *values))
    return Table(("", "before", addition.effect), rows, f"What {addition.effect} did")
