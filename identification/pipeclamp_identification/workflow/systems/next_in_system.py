"""What to do, and the command to run, after a coupled system was computed: once, over frequencies, or over cases."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path, PurePath

from pipeclamp_identification.diagnosis.further_test.limits import Limits, limits_words
from pipeclamp_identification.workflow.next_command import NEXT_TEST, PLANNED
from pipeclamp_identification.workflow.next_step import NextStep
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.shell import shell_line
from pipeclamp_models.base.tables import pl
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.range import celsius_tested
from pipeclamp_system.cosim.building import law_in
from pipeclamp_system.cosim.law_conditions import motion_conditions
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.description.system import SystemDescription, read_system
from pipeclamp_system.response.curves import FrequencyResponse
from pipeclamp_system.study.case import TRUSTED
from pipeclamp_system.study.description import Study

BANDS = "95"
"""Per cent that bands hold where nobody has said how many."""


def after_cosim(
    result: CosimResult, system: Path, output: str, report: Path | None = None, bands: float | None = None
) -> NextStep:
    """Give what comes after a co-simulation.

    Args:
        result: what came out.
        system: SYSTEM.toml.
        output, report, bands: as the command was told; without bands how sure it is comes next, where laws tell.
    """
    given = ("cosim", str(system), "-o", output, *(("--report", str(report)) if report else ()))
    again = shell_line(*given)
    if not result.trusted:
        return NextStep(again, result.remedy())
    if result.unsettled:
        return NextStep(again, "with a larger stop_s")
    if result.mistaken:
        return NextStep(again, f"with solve = true at {' and '.join(result.mistaken)}")
    description = read_system(system)
    beyond = {name: _moved(result, name) for name in result.out_of_range}
    if planned := _tests_beyond(description, system, beyond):
        return planned
    if description.excitation.kind != "record" and description.pipe.file is not None:
        return NextStep(_response(system))
    if bands is None and _is_told(_cosim_refuse, system):
        return NextStep(shell_line(*given, "--bands", BANDS))
    return NextStep(_packaged(system))


def after_response(
    found: FrequencyResponse, system: Path, output: str, report: Path | None = None, bands: float | None = None
) -> NextStep:
    """Give what comes after a frequency response; arguments as for `after_cosim`."""
    given = ("response", str(system), "-o", output, *(("--report", str(report)) if report else ()))
    again = shell_line(*given)
    if found.doubtful_dots:
        return NextStep(again, "with a smaller step_s or scheme = 'implicit'")
    if found.left_out and found.stated_harmonics:
        return NextStep(again, "without harmonics in [response]")
    if found.left_out:
        return NextStep(shell_line("cosim", str(system), "-o", "cosim.csv"), "with a frequency where it is in doubt")
    if any(curve.followed.unbounded for curve in found.curves):
        return NextStep(again, "with the pipe's damping in its file, or a law with damping")
    if not all(curve.followed.complete for curve in found.curves):
        return NextStep(again, "with other ends of [response]")
    beyond = {
        name: [state.beyond[place] for curve in found.curves for state in curve.states if state.beyond[place]]
        for place, name in enumerate(found.clamp_names)
    }
    if planned := _tests_beyond(read_system(system), system, {name: own for name, own in beyond.items() if own}):
        return planned
    if _is_told(_response_refuse, system) and not any(curve.followed.in_time for curve in found.curves):
        return NextStep(shell_line(*given, "--bands", BANDS) if bands is None else shell_line("plan", str(system)))
    return NextStep(_packaged(system))


def after_sweep(study: Study, frame: pl.DataFrame, path: Path, output: str, report: Path | None = None) -> NextStep:
    """Give what comes after a study.

    Args:
        study, frame: the study, and the table that came out.
        path: STUDY.toml.
        output, report: as the command was told.
    """
    again = shell_line("sweep", str(path), "-o", output, *(("--report", str(report)) if report else ()))
    failed = frame.filter(pl.col("error") != "").height
    if failed:
        return NextStep(again, f"once the {failed} cases without a result are put right, or varied no more")
    if TRUSTED in frame.columns and not frame[TRUSTED].drop_nulls().all():
        return NextStep(again, "with a smaller step_s")
    system = path.parent / study.description.system
    if study.description.measure == "cosim":
        line = shell_line("cosim", str(system), "-o", "cosim.csv", "--report", "cosim.html")
    else:
        line = _response(system)
    return NextStep(line, "with the case that you choose")


def after_band_plan(system: Path, again: str, *, proposed: bool, driven: bool) -> NextStep:
    """Give what comes after loop tests were sought that make a pipe's peak surer.

    Args:
        system: SYSTEM.toml.
        again: the shell line that sought them.
        proposed: whether one was found.
        driven: whether its drive signal has been written.
    """
    if not proposed:
        return NextStep(_packaged(system))
    if not driven:
        return NextStep(f"{again} --drive {NEXT_TEST}.csv")
    return NextStep(again, "once that test has been run, and the law is identified from it too")


def _response(system: Path) -> str:
    return shell_line("response", str(system), "-o", "response.csv", "--report", "response.html")


def _packaged(system: Path) -> str:
    return shell_line("system", str(system), "-o", f"{PurePath(system).stem}.ssp")


def _moved(result: CosimResult, name: str) -> list[Mapping[str, float]]:
    """Give A (mm), f (Hz) and T (K) of a clamp's motion."""
    moved = motion_conditions(result, name)
    clamp = next(one for one in result.system.clamps if one.at == name)
    return [{"A": moved.A, "f": moved.f, "T": clamp.temperature_C + CELSIUS}]


def _tests_beyond(
    description: SystemDescription, system: Path, beyond: Mapping[str, Sequence[Mapping[str, float]]]
) -> NextStep | None:
    """Give the plan of tests that reach as far as a clamp does beyond its law's data; None where none does.

    Args:
        description: of the system, in
        system: SYSTEM.toml.
        beyond: conditions of clamps, by name.
    """
    for clamp in description.clamps:
        if clamp.at not in beyond or clamp.law is None:
            continue
        limits = Limits()
        known = law_in(system.parent, clamp.law).range
        for symbol in ("A", "f", "T"):
            if symbol in known:
                one_range, shift = known[symbol], CELSIUS if symbol == "T" else 0.0
                ends = celsius_tested(one_range) if symbol == "T" else (one_range.minimum, one_range.maximum)
                values = [*ends, *(one[symbol] - shift for one in beyond[clamp.at] if symbol in one)]
                limits = limits.with_range(symbol, (min(values), max(values)))
        law = str(system.parent / clamp.law) if PurePath(clamp.law).suffix else clamp.law
        line = shell_line("plan", "-o", PLANNED, "--law", law, "--limits", limits_words(limits))
        return NextStep(line, f"to test as far as {clamp.at} moves")
    return None


def _is_told(refuse: Callable[[Path], None], system: Path) -> bool:
    """Tell whether a system's laws say how sure they are."""
    try:
        refuse(system)
    except UserError:
        return False
    return True


def _cosim_refuse(system: Path) -> None:
    from pipeclamp_system.bands.ensemble import refuse

    refuse(system, float(BANDS))


def _response_refuse(system: Path) -> None:
    from pipeclamp_system.bands.response import refuse

    refuse(system, float(BANDS), {})
