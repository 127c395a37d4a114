"""What comes after something was built for simulation: an FMU, or a system for other masters."""

from __future__ import annotations

from pipeclamp_identification.workflow.next_step import NextStep
from pipeclamp_models.base.shell import shell_line

SYSTEM = "system.toml"
"""What a system's description is called, where nobody has named it."""


def after_clamp_fmu(fmu: str) -> NextStep:
    """Give what comes after a clamp's FMU was built: a system that has it."""
    return NextStep(after_packaging(SYSTEM), f"with fmu = '{fmu}' at a clamp of {SYSTEM}")


def after_pipe_fmu(fmu: str) -> NextStep:
    """Give what comes after a pipe's FMU was built: a system that has it."""
    return NextStep(after_packaging(SYSTEM), f"with fmu = '{fmu}' as the pipe of {SYSTEM}")


def after_packaging(system: str) -> str:
    """Give the shell line to run after a system was packaged for other masters: what they should come to."""
    return shell_line("cosim", system, "-o", "cosim.csv", "--report", "cosim.html")
