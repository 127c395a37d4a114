"""A system packaged for other masters, told: the step that they may take."""

from __future__ import annotations

from pipeclamp_system.cosim.parallel_step import ParallelStep
from pipeclamp_system.description.trust_mark import doubt


def parallel_words(found: ParallelStep) -> str:
    """Say in which steps masters may couple that do so in parallel."""
    if found.step is None:
        masters = f"masters that couple in parallel, as most do, in no step down to {found.tried:.3g} s"
        return doubt(f"{masters}; use a master that iterates, or pipeclamp cosim")
    how = "" if found.step == found.tried else f"; foretold from {found.tried!r} s"
    return (
        f"most masters couple in parallel: give them steps of {found.step!r} s or less{how}, in which the "
        f"displacement errs by {found.error:.1%}; libcosim reads the step from the SSP"
    )
