"""Add an effect to a law, or take one out: refit everything, and say what the error did."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from pipeclamp_identification.diagnosis.named import parts_of
from pipeclamp_identification.diagnosis.thresholds import STILL_AS_GOOD, TAKEN_SHARE, ratio_without_powers
from pipeclamp_identification.workflow.tests import Tests
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import HistoryStep, LawFile, NamedKind, Provenance, former_law_of, law_of, structure_of
from pipeclamp_models.law.law import Structure, with_effect
from pipeclamp_models.law.range import rounded
from pipeclamp_models.law.step import BeforeAfter, LawStep, read_step


@dataclass(frozen=True)
class LawChange:
    """A law refitted with something changed, and what that did.

    Attributes:
        step: what was changed.
        before, after: the law's file before, and the one with the change.
        nrmse: error on the campaign before and after, as a share of the force.
        heldout: error on left-out groups of conditions before and after.
        noise_nrmse: the scatter that no law can explain; None where it isn't known.
    """

    step: LawStep
    before: LawFile
    after: LawFile
    nrmse: BeforeAfter
    heldout: BeforeAfter
    noise_nrmse: float | None


def add_effect(
    file: LawFile,
    effect: str,
    tests: Tests,
    *,
    provenance: Provenance,
    declared: Collection[Declaration] = (),
    kind: NamedKind | None = None,
    start: Mapping[str, float] | None = None,
    instead: Collection[str] = (),
    progress: Progress = silent,
) -> LawChange:
    """Add an effect to a law and refit everything to tests.

    Args:
        file: the law.
        effect: name of the effect.
        tests: what it is refitted to.
        declared: a user's own effects.
        provenance: how the new file comes about.
        kind: how a diagnosis meant it; what a part proves is remembered in the law's history.
        start: values to begin at, by name, where they are known better than from the law.
        instead: effects of the law that go for it.
        progress: is told what is being done.

    Raises:
        UserError: the effect isn't known or is there already, or the data can't serve it.
    """
    old = structure_of(file).with_declared(declared)
    new = with_effect(replace(old, effects=tuple(name for name in old.effects if name not in instead)), effect)
    step = LawStep(come=(effect,), gone=tuple(instead))
    return _changed(file, new, step, tests, provenance=provenance, kind=kind, start=start, progress=progress)


def add_effects(
    file: LawFile,
    effects: Sequence[str],
    tests: Tests,
    *,
    provenance: Provenance,
    declared: Collection[Declaration] = (),
    kind: NamedKind | None = None,
    start: Mapping[str, float] | None = None,
    progress: Progress = silent,
) -> list[LawChange]:
    """Add effects to a law one after the other, as `add_effect` does; give each step.

    The last one starts at `start`, which is of the law with all of them: one alone may do badly there.
    """
    steps: list[LawChange] = []
    for place, effect in enumerate(effects, 1):
        change = add_effect(
            steps[-1].after if steps else file, effect, tests, provenance=provenance, declared=declared, kind=kind,
            start=start if place == len(effects) else None, progress=progress,
        )  # fmt: skip
        steps.append(change)
    return steps


def helps(steps: Sequence[LawChange]) -> bool:
    """Tell whether these steps lower the error on left-out conditions, and not by what nothing determines.

    By how little may say nothing: of an error that scatter from run to run makes, what was missing may be a trifle.
    """
    falls = steps[-1].heldout.after < steps[0].heldout.before
    return falls and (takes(steps, TAKEN_SHARE) or any(map(_brings_what_is_determined, steps)))


def _brings_what_is_determined(change: LawChange) -> bool:
    """Tell whether a law has a new parameter that is known better than by its own size."""
    new = (entry for name, entry in change.after.coefficients.items() if name not in change.before.coefficients)
    return any(entry.standard_error is not None and entry.standard_error < abs(entry.value) for entry in new)


def takes(steps: Sequence[LawChange], share: float) -> bool:
    """Tell whether these steps take such a share of the mean square beyond scatter on left-out conditions."""
    before, after = steps[0].heldout.before, steps[-1].heldout.after
    scatter = steps[0].noise_nrmse or 0.0
    return before**2 - after**2 >= share * (before**2 - scatter**2)


def remove_effect(
    file: LawFile,
    effect: str,
    tests: Tests,
    *,
    provenance: Provenance,
    progress: Progress = silent,
) -> LawChange:
    """Take an effect out of a law and refit the rest to tests; arguments as for `add_effect`.

    Raises:
        UserError: the law hasn't got the effect.
    """
    old = structure_of(file)
    if effect not in old.effects:
        raise UserError(f"effect {effect!r} isn't in the law; it has {', '.join(old.effects) or 'no effects'}")
    new = replace(old, effects=tuple(name for name in old.effects if name != effect))
    return _changed(file, new, LawStep(gone=(effect,)), tests, provenance=provenance, progress=progress)


def refit(
    file: LawFile,
    tests: Tests,
    *,
    provenance: Provenance,
    start: Mapping[str, float] | None = None,
    progress: Progress = silent,
) -> LawChange:
    """Fit a law as it is made to tests anew, as where others have joined; arguments as for `add_effect`.

    What is held stays held, and the law's history goes on.

    Raises:
        UserError: the tests can't serve the law.
    """
    return _changed(file, structure_of(file), LawStep(), tests, provenance=provenance, start=start, progress=progress)


def without_spares(
    file: LawFile, keep: str, tests: Tests, *, provenance: Provenance, progress: Progress = silent
) -> list[LawChange]:
    """Take out, one after another, the effects that a law does as well without; give each step; see `add_effect`.

    Args:
        keep: the effect that was added last, which isn't asked.
    """
    steps: list[LawChange] = []
    while (spare := tests.superfluous(file, keep, progress)) is not None:
        change = remove_effect(file, spare, tests, provenance=provenance, progress=progress)
        if not stays_as_good(change):
            break
        steps.append(change)
        file = change.after
    return steps


def stays_as_good(change: LawChange, ratio: float = STILL_AS_GOOD) -> bool:
    """Tell whether the error on left-out conditions rises by no more than a ratio, and that of all samples too."""
    return change.heldout.after <= change.heldout.before * ratio and fits_samples(change, ratio)


def clearly_better(change: LawChange) -> bool:
    """Tell whether the error on left-out conditions falls by a material part, and that of all samples doesn't rise."""
    return change.heldout.after * STILL_AS_GOOD < change.heldout.before and change.nrmse.after <= change.nrmse.before


def fits_samples(change: LawChange, ratio: float = STILL_AS_GOOD) -> bool:
    """Tell whether the error of all samples rises by no more than a ratio, by default one that isn't material.

    Left-out conditions are foretold in the harmonics that loops keep. What a law does wrong beyond them, at a reversal,
    shows in the samples alone.
    """
    return change.nrmse.after <= change.nrmse.before * ratio


def as_well_without(change: LawChange, keep: str) -> str:
    """Say that an effect went, and for which one."""
    return f"the law does as well without {change.step.effect}, now that it has {keep}"


def exchange(
    file: LawFile, structure: Structure, tests: Tests, *, provenance: Provenance, progress: Progress = silent
) -> LawChange:
    """Put another structure, with one thing exchanged, in a law's place and refit everything.

    Args:
        file: the law.
        structure: what takes its place.
        tests, provenance, progress: as for `add_effect`.

    Raises:
        UserError: the data can't serve it.
    """
    if held := tuple(name for name, _ in structure.frozen if file.coefficients[name].state != "held"):
        step = LawStep(held=held)
    elif structure.base == file.base:
        come = tuple(name for name in structure.effects if name not in file.effects)
        step = LawStep(come, tuple(name for name in file.effects if name not in structure.effects))
    else:
        step = LawStep(base=structure.base, alone=bool(file.effects) and not structure.effects)
    of_parts = any(name not in structure.effects for name in parts_of(file))
    kind: NamedKind | None = "part" if of_parts else None
    return _changed(file, structure, step, tests, provenance=provenance, kind=kind, progress=progress)


def with_powers_back(
    file: LawFile, tests: Tests, *, provenance: Provenance, progress: Progress = silent
) -> LawChange | None:
    """Fit the powers of the amplitude again that a law's memory spared; None where there are none; see `add_effect`.

    A law that lacks something still may have lost powers that are the device's own, which nothing else gives back.
    """
    old = structure_of(file)
    new = _with_powers_free(old, file)
    freed = tuple(name for name, _ in old.frozen if name not in dict(new.frozen))
    if not freed:
        return None
    return _changed(file, new, LawStep(freed=freed), tests, provenance=provenance, progress=progress)


def without_spare_powers(
    file: LawFile, tests: Tests, *, complete: bool, provenance: Provenance, progress: Progress = silent
) -> LawChange | None:
    """Take out the powers of the amplitude that a law's memory spares; None where it needs each.

    Args:
        complete: whether nothing is missing, which decides by how little the law may err more without them.
        file, tests, provenance, progress: as for `add_effect`.
    """
    structure = tests.without_spare_powers(file, complete, progress)
    if structure is None:
        return None
    change = exchange(file, structure, tests, provenance=provenance, progress=progress)
    return change if stays_as_good(change, ratio_without_powers(complete)) else None


def _with_powers_free(structure: Structure, file: LawFile) -> Structure:
    """Give a structure with the powers fitted again that the memory of the law so far spared."""
    spared = {name for one in file.history for name in read_step(one.step).held}
    return replace(structure, frozen=tuple((name, value) for name, value in structure.frozen if name not in spared))


def _changed(
    file: LawFile,
    new: Structure,
    step: LawStep,
    tests: Tests,
    *,
    provenance: Provenance,
    kind: NamedKind | None = None,
    start: Mapping[str, float] | None = None,
    progress: Progress,
) -> LawChange:
    """Refit a law with another structure and state the error before and after."""
    if not new.equations.states:  # what spared them is gone
        new = _with_powers_free(new, file)
    done = tests.refit(file, new, new.own({**law_of(file).values, **(start or {})}), progress)
    after = done.fitted.file(name=file.name, provenance=provenance)
    history = file.history or (HistoryStep(step=file.name, nrmse=rounded(done.nrmse.before)),)
    left = {"refitted_nrmse": rounded(done.heldout.before), "stage": former_law_of(file)}
    history = (*history[:-1], history[-1].model_copy(update=left))
    last = HistoryStep(
        step=str(step), kind=kind, nrmse=rounded(done.nrmse.after), refitted_nrmse=rounded(done.heldout.after),
        few_settings=done.few_settings or None,
    )  # fmt: skip
    after = after.model_copy(update={"history": (*history, last), "notes": file.notes})
    return LawChange(step, file, after, done.nrmse, done.heldout, done.noise_nrmse)
