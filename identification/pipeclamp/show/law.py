"""A law told: its parameters, and what a change of it did."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipeclamp.show.table import SINGLE_CYCLES, Table, cell
from pipeclamp_identification.campaign.description import UNTIMED
from pipeclamp_identification.comparison.in_the_middle import BY_RATIO, loop_in_the_middle
from pipeclamp_identification.comparison.names import labels_of
from pipeclamp_identification.comparison.sentences import about_mean, sentence
from pipeclamp_identification.diagnosis.thresholds import STILL_AS_GOOD
from pipeclamp_identification.fitting.groups_answer import LEFT_OUT_BESIDE, per_group_words
from pipeclamp_identification.signals.levels import VARIED_SHARE
from pipeclamp_identification.workflow.change import LawChange
from pipeclamp_models.base.digits import error_goes, one_digit, plain, with_error
from pipeclamp_models.base.signals import REFERENCES
from pipeclamp_models.base.units import CELSIUS, unit_shown
from pipeclamp_models.law.file import CoefficientEntry, FitQuality, HistoryStep, LawFile, structure_of
from pipeclamp_models.law.outline import ParameterOutline, bound_at
from pipeclamp_models.law.range import conditions_beyond
from pipeclamp_models.law.step import read_step

MOVED_STANDARD_ERRORS = 2.0
"""A parameter that changes by more than so many of its standard errors has moved."""


def coefficient_table(file: LawFile) -> Table:
    """Give the parameters with unit, standard error and how they came about."""
    outlines = outlines_of(file)
    meanings = {name: outline.meaning for name, outline in outlines.items()}
    rows = [
        (
            name,
            value_shown(entry, outlines.get(name)),
            entry.standard_error,
            unit_shown(entry.unit),
            entry.state,
            entry.reason or entry.meaning or meanings[name],
        )
        for name, entry in file.coefficients.items()
    ]
    return Table(("parameter", "value", "standard error", "unit", "state", "meaning"), rows, f"Law {file.name}")


def value_shown(entry: CoefficientEntry, outline: ParameterOutline | None) -> str | float:
    """Give a parameter's value; one that ran into a bound as that bound, and marked so: "0 (at its bound)".

    A bound in sizes of the data isn't known here; the value stands for it.
    """
    if entry.state != "at_bound":
        return entry.value
    bounds = (outline.lower, outline.upper) if outline else ()
    return f"{cell(bound_at(entry.value, *bounds))} (at its bound)"


def outlines_of(file: LawFile) -> dict[str, ParameterOutline]:
    """Give the parameters of a law's equations, by name."""
    return {outline.name: outline for outline in structure_of(file).equations.parameters}


def fit_words(fit: FitQuality) -> str:
    """Say how well a law fits its data."""
    if fit.of_metrics:
        return f"error {fit.nrmse:.2%} in dW and W (rms of log ratios)"
    scatter = f" (scatter {fit.noise_nrmse:.2%})" if fit.noise_nrmse is not None else f"; {SINGLE_CYCLES}"
    preload = f"; {about_mean(fit.mean_share, fit.nrmse, fit.noise_nrmse)}" if fit.mean_share else ""
    return f"error {fit.nrmse:.2%} of the rms force{scatter}{preload}"


def doubts(file: LawFile) -> list[str]:
    """Say how well a law is known in the middle of its tests, what of it less well, and how groups of runs differ."""
    lines = in_the_middle_words(file)
    lines += [
        f"{entry.pair[0]} and {entry.pair[1]} can hardly be told apart (correlation {entry.value:.3f})."
        for entry in file.correlations
    ]
    untimed = (UNTIMED,) if not file.data.is_timed else ()
    lines += [f"Of its data: {words}." for words in (*untimed, *(file.data.warnings or ()))]
    if file.fit and file.fit.unsettled:
        lines.append(
            f"On {file.fit.unsettled} of the cycles that the law was fitted to, its memory doesn't become periodic: "
            "the force that was compared there is that of one repetition among others."
        )
    groups = per_group_words(file.groups or ())
    return [*lines, *groups, *([sentence(LEFT_OUT_BESIDE)] if groups else [])]


def in_the_middle_words(file: LawFile) -> list[str]:
    """Say what a law's loop comes to in the middle of its tests, and whether its parameters stand outside of these.

    Nothing where the loop's errors aren't known.
    """
    loop = loop_in_the_middle(file)
    if loop is None:
        return []
    varied = {
        name
        for name, each in file.range.items()
        if each.maximum - each.minimum > VARIED_SHARE * max(abs(each.maximum), abs(each.minimum))
    }
    shown = {**loop.conditions, **({"T": loop.conditions["T"] - CELSIUS} if "T" in loop.conditions else {})}
    units = {name: unit_shown(each.unit) for name, each in file.range.items()} | {"T": "°C"}
    where = ", ".join(
        f"{name} {plain(value, 3)}" + ("" if units[name] == "in its name" else f" {units[name]}")
        for name, value in shown.items()
        if name in (*BY_RATIO, "T") or name in varied
    )
    stiffness = with_error(loop.stiffness, loop.stiffness_error)
    energy = with_error(loop.dissipated_energy, loop.energy_error)
    where = f"about {plain(file.data.about_mm, 3)} mm, {where}" if file.data.about_mm else where
    words = [f"In the middle of its tests ({where}): {stiffness} N/mm and {energy} J a cycle."]
    if conditions_beyond(file, {name: REFERENCES[f"{name}_0"] for name in BY_RATIO}):
        words.append("Its parameters stand at 1 mm, 1 Hz and 20 °C, outside of these tests, and may be less sure.")
    return words


def per_group_table(column: str, files: Mapping[str, LawFile]) -> Table:
    """Give the laws of groups side by side, by the stem of their files."""
    laws = list(files.values())
    rows: list[Sequence[str | float | None]] = [
        ("runs", "", *(float(law.data.runs_used) for law in laws)),
        ("error", "%", *(100 * law.fit.nrmse if law.fit else None for law in laws)),
        *parameters_table(laws).rows,
    ]
    return Table(("", "unit", *files), rows, f"A law for each {column}; value ± standard error")


def laws_table(laws: Sequence[tuple[LawFile, float, float | None]]) -> Table:
    """Give laws held against the same tests: file, error, and the scatter of it where it is known; as they came."""
    labels = labels_of(file for file, *_ in laws)
    rows = [
        (
            label,
            " + ".join((file.base, *file.effects)),
            100 * error,
            None if scatter is None else 100 * scatter,
            None if not scatter else error / scatter,
        )
        for label, (file, error, scatter) in zip(labels, laws, strict=True)
    ]
    header = ("law", "made of", "RMS error / %", "scatter / %", "error over scatter")
    return Table(header, rows, "all on the same runs; an error over scatter of 1 is the best possible")


def least_words(files: Sequence[LawFile], place: int) -> str:
    """Say which of several laws errs least, and that what follows is about it."""
    return f"{labels_of(files)[place]} errs least of the {len(files)} laws; all that follows is about it."


def parameters_table(files: Sequence[LawFile]) -> Table:
    """Give the parameters of laws side by side."""
    names = dict.fromkeys(name for law in files for name in law.coefficients)
    rows: list[Sequence[str | float | None]] = []
    outlines = [outlines_of(law) for law in files]
    for name in names:
        entries = [law.coefficients.get(name) for law in files]
        shown = (_shown(entry, known.get(name)) for entry, known in zip(entries, outlines, strict=True))
        rows.append((name, unit_shown(next(entry.unit for entry in entries if entry)), *shown))
    return Table(("parameter", "unit", *labels_of(files)), rows, "value ± standard error")


def stages_table(file: LawFile) -> Table | None:
    """Give a law's parameters at each step of its history, itself last; None where only the last is known."""
    steps = [(step.step, step.stage.values) for step in file.history if step.stage is not None]
    if not steps:
        return None
    names = dict.fromkeys([*(name for _, values in steps for name in values), *file.coefficients])
    units = {name: unit_shown(entry.unit) for name, entry in file.coefficients.items()}
    outlines = outlines_of(file)
    now = {name: value_shown(entry, outlines.get(name)) for name, entry in file.coefficients.items()}
    rows = [(name, units.get(name, ""), *(values.get(name) for _, values in steps), now.get(name)) for name in names]
    columns = (*(step for step, _ in steps), file.history[-1].step)
    return Table(("parameter", "unit", *columns), rows, "the law's parameters, step by step")


def _shown(entry: CoefficientEntry | None, outline: ParameterOutline | None) -> str | None:
    if entry is None:
        return None
    error = "" if entry.standard_error is None else f" ± {one_digit(entry.standard_error)}"
    return f"{cell(value_shown(entry, outline))}{error}"


def change_table(change: LawChange) -> Table:
    """Give what a change of a law did to the error, and which parameters came, went, or moved beyond doubt."""
    scatter = None if change.noise_nrmse is None else 100 * change.noise_nrmse
    rows: list[Sequence[str | float | None]] = [
        ("error on the runs used / %", 100 * change.nrmse.before, 100 * change.nrmse.after),
        ("error on left-out conditions, by refits / %", 100 * change.heldout.before, 100 * change.heldout.after),
        ("scatter that no law explains / %", scatter, scatter),
    ]
    before, after = change.before.coefficients, change.after.coefficients
    names = list(dict.fromkeys((*before, *after)))
    moved = [name for name in names if _moved(before.get(name), after.get(name))]
    outlines = [outlines_of(law) for law in (change.before, change.after)]
    for name in moved:
        unit = unit_shown((after.get(name) or before[name]).unit)
        values = (
            value_shown(law[name], known.get(name)) if name in law else None
            for law, known in zip((before, after), outlines, strict=True)
        )
        rows.append((f"{name} / {unit}", *values))
    stay = len(names) - len(moved)
    said = f"; {stay} further parameters stay within {MOVED_STANDARD_ERRORS:g} of their standard errors" if stay else ""
    return Table(("", "before", str(change.step)), rows, f"What {change.step} did{said}")


def not_fitted(change: LawChange) -> list[str]:
    """Say which parameters came with a change and aren't fitted, and why."""
    held: dict[str, list[str]] = {}
    for name, entry in change.after.coefficients.items():
        if name not in change.before.coefficients and entry.state == "frozen":
            held.setdefault(entry.reason, []).append(name)
    return [f"Not fitted: {', '.join(names)} ({reason})." for reason, names in held.items()]


def vain_words(history: Sequence[HistoryStep], steps: int = 1) -> str:
    """Say that what was added last doesn't help, and which law to keep; empty where it does, or nothing was added.

    Where it fits the tests better, and they have too few settings for left-out ones to tell, that is said instead.

    Args:
        history: of the law.
        steps: how many of its last steps were taken at once, on the same tests.
    """
    if not 0 < steps < len(history):
        return ""
    taken = [read_step(one.step) for one in history[-steps:]]
    without, having = history[-steps - 1].refitted_nrmse, history[-1].refitted_nrmse
    if not all(step.adds for step in taken):
        return ""
    if without is None or having is None or having < without:
        return ""
    names = " and ".join(step.effect for step in taken)
    before, after = history[-steps - 1].nrmse, history[-1].nrmse
    if history[-1].few_settings and before > STILL_AS_GOOD * after:
        return (
            f"Left-out conditions can't tell whether {names} helps: these tests have so few settings that, without "
            "one of them, the others hardly show what each condition does. The error on left-out conditions goes "
            f"{error_goes(without, having)}, that on the runs used {error_goes(before, after)}; test at more levels of "
            "what varies"
        )
    said, did = "The error", "doesn't fall"
    if having > STILL_AS_GOOD * without:
        said, did = "The law got worse: the error", "rises"
    gone = "it" if steps == 1 else "them"
    return (
        f"{said} on left-out conditions {did} with {names} ({error_goes(without, having)}); keep the law without {gone}"
    )


def _moved(before: CoefficientEntry | None, after: CoefficientEntry | None) -> bool:
    """Tell whether a parameter is new, gone, or changed by more than its doubt."""
    if before is None or after is None:
        return True
    return abs(after.value - before.value) > MOVED_STANDARD_ERRORS * (after.standard_error or 0.0)
