"""What is known of an import once all its runs are: whether it can serve, and what to know of its conditions."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from pipeclamp_identification.campaign.description import ImportedCut
from pipeclamp_identification.campaign.plausibility import PEAK_TO_PEAK, STATED_APART
from pipeclamp_identification.importing.channels.columns import Mapped
from pipeclamp_identification.importing.conditions import Pattern
from pipeclamp_identification.importing.records.named_run import NamedRun
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.said import counted, few_of

TEMPERATURE_APART = 15.0
"""K by which an oven may miss what was set in it: a name's number that is farther off is no temperature."""


def refuse_none(files: int, cut: Sequence[ImportedCut], notes: Sequence[str]) -> None:
    """Refuse files none of which holds a run.

    Args:
        files: how many.
        cut: what can't be used, and why.
        notes: what to know of them.

    Raises:
        UserError: always.
    """
    reasons = "\n".join(f"  {one.file}, {one.samples[0]} to {one.samples[1]}: {one.why}" for one in cut[:10])
    raise UserError(
        f"no run can be used, in {counted(files, 'file')}; expected loops of force and displacement\n"
        + "\n".join([reasons, *(f"  {note}" for note in notes)])
    )


def refuse_reversed(runs: Sequence[NamedRun]) -> None:
    """Refuse runs whose force has the wrong sign in each of them.

    Raises:
        UserError: it has; the columns are named that turn it.
    """
    if not runs or not all(run.reversed for run in runs):
        return
    raise UserError(
        "the force of all runs has the wrong sign: stiffness and dissipated energy are both negative; force is "
        f"what the rig applies, positive with positive displacement; expected it turned, for example\n  "
        f"{_turned(runs[0].mapped)}"
    )


def reversed_words(runs: Sequence[NamedRun]) -> str:
    """Say how to import runs whose force has the wrong sign, where that of others hasn't; empty where none has."""
    turned = [run for run in runs if run.reversed]
    if not turned:
        return ""
    files = few_of(list(dict.fromkeys(run.planned.source.file for run in turned)), most=3)
    return (
        f"the force of {len(turned)} of {counted(len(runs), 'run')} has the wrong sign ({files}): import these files "
        f"into one folder with {_turned(turned[0].mapped)}, then the others into the same folder without it"
    )


def _turned(mapped: Mapped) -> str:
    turned = [
        replace(one, conversion=replace(one.conversion, factor=-one.conversion.factor)) if one.ours == "force" else one
        for one in mapped.columns
    ]
    return replace(mapped, columns=tuple(turned), questions=()).option()


def contradicted(runs: Sequence[NamedRun], timed: bool, column: str, values: Sequence[float]) -> bool:
    """Tell whether most runs were measured otherwise than the files' names would state.

    Args:
        runs: the runs.
        timed: whether time was measured; no frequency counts otherwise.
        column: of runs.csv.
        values: what the names would state there, of each run.
    """
    if column == "frequency_Hz" and not timed:
        return True
    if column == "temperature_C":
        # what stands above a table may be that of another test: names may contradict it, not the other way round
        shown = [None if run.above else run.planned.row.get(column) for run in runs]
        pairs = [(own, value) for own, value in zip(shown, values, strict=True) if isinstance(own, float)]
        apart = [abs(own - value) > TEMPERATURE_APART for own, value in pairs]
    elif column in ("amplitude_mm", "frequency_Hz"):
        measured = [run.planned.measured and run.planned.measured[column == "frequency_Hz"] for run in runs]
        pairs = [(own, value) for own, value in zip(measured, values, strict=True) if own is not None]
        apart = [not _twice(own, value) and abs(own - value) > STATED_APART * value for own, value in pairs]
    else:
        return False
    return 2 * sum(apart) > len(apart)


def without_doubtful_temperatures(runs: Sequence[NamedRun], guess: str) -> tuple[list[NamedRun], list[str]]:
    """Take no temperature from above tables where the files' names state others.

    Args:
        runs: the runs.
        guess: the pattern that the names seem to follow.

    Returns:
        the runs, and which temperatures stand above tables, in words.
    """
    named = Pattern(guess).settings if guess else lambda stem: None

    def is_doubtful(run: NamedRun) -> bool:
        value = (named(run.own) or {}).get("temperature_C") if run.above else None
        if run.above is None or not isinstance(value, float):
            return False
        return abs(value - (run.above.temperature_C or value)) > TEMPERATURE_APART

    files: dict[str, list[str]] = {}
    for run in runs:
        if run.above:
            files.setdefault(run.above.words, []).append(run.planned.source.file)
    notes = [f"{few_of(list(dict.fromkeys(own)), most=1)}: {words}" for words, own in files.items()]
    apart = [is_doubtful(run) for run in runs]
    if any(apart):
        notes.append(
            f"the names of {sum(apart)} of these files state another temperature: neither is taken; import again "
            "with --pattern, or state it in runs.csv"
        )
    return [_without_temperature(run) if out else run for run, out in zip(runs, apart, strict=True)], notes


def conditions_words(names: Collection[str], runs: Sequence[NamedRun], again: Collection[str]) -> list[str]:
    """Say which rows of the table of conditions met no run, and which runs no row.

    Args:
        names: of that table.
        runs: the runs.
        again: files that are known.
    """
    met = {*again, *(run.known_as for run in runs)}
    idle = [repr(name) for name in names if name not in met]
    bare = [run.planned.name for run in runs if not run.known_as]
    words = []
    if idle:
        words.append(f"--conditions: no run here is called, nor from a file that is called, {few_of(idle)}")
    if bare and names:
        words.append(f"--conditions: says nothing of {len(bare)} of {len(runs)} runs: {few_of(bare)}")
    return words


def _without_temperature(run: NamedRun) -> NamedRun:
    return replace(run, planned=replace(run.planned, row={**run.planned.row, "temperature_C": None}))


def _twice(amplitude: float, stated: float) -> bool:
    """Tell whether an amplitude is that of a stroke from peak to peak that was stated."""
    return PEAK_TO_PEAK[0] * stated < amplitude < PEAK_TO_PEAK[1] * stated
