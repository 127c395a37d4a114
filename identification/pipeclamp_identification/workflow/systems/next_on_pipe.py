"""What to do, and the command to run, after a coupled system was held against what was measured on the pipe."""

from __future__ import annotations

from pipeclamp_identification.attribution.attributed import Attributed
from pipeclamp_identification.workflow.next_step import NextStep
from pipeclamp_models.base.shell import shell_line
from pipeclamp_system.description.system import SystemDescription


def after_pipe_comparison(found: Attributed, system: str, measured: str, *, reported: bool) -> NextStep:
    """Give what comes after a system was held against what was measured on its pipe.

    Args:
        found: the verdict.
        system, measured: the system's file and the measurement's folder, as they are called.
        reported: whether a report was asked for, so that the place of the error can be seen.
    """
    attribution = found.attribution
    again = shell_line("compare", system, measured)
    if attribution is None:
        return NextStep(again, "once more is measured")
    if attribution.verdict == "complete":
        return NextStep(_used(found.compared.system, system))
    if attribution.verdict == "unknown":
        if attribution.branch_unknown:
            return NextStep(again, "once it says which way it was swept")
        if attribution.noise_unknown:
            return NextStep(again, "once some sines are repeated")
        if not reported:
            return NextStep(shell_line("compare", system, measured, "--report", "compare.html"))
        return NextStep(again, "once another level or probe is measured")
    if found.proposal is not None:
        return NextStep(again, "once that is measured too")
    what = "once it is put right" if attribution.verdict == "wrong" else "once it is known which, and put right"
    return NextStep(again, what)


def _used(description: SystemDescription, system: str) -> str:
    """Give the line that uses a system that nothing is found wrong with."""
    command = "response" if description.response else "cosim"
    return shell_line(command, system, "-o", f"{command}.csv", "--report", f"{command}.html")
