"""A coupled system computed, in time or over frequencies, with its bands where they are asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.run import ShareDone, run_system
from pipeclamp_system.description.system import read_system

if TYPE_CHECKING:
    from pipeclamp_system.bands.ensemble import RunBands
    from pipeclamp_system.bands.response_bands import ResponseBands
    from pipeclamp_system.response.curves import FrequencyResponse


@dataclass(frozen=True, eq=False)
class CoSimulated:
    """A run in time.

    Attributes:
        result: the run, with the ends of the bands among its columns.
        bands: how sure it is, where that was asked for.
    """

    result: CosimResult
    bands: RunBands | None = None


@dataclass(frozen=True, eq=False)
class Responded:
    """A frequency response.

    Attributes:
        found: curves, and co-simulations on them.
        bands: how sure they are, where that was asked for.
    """

    found: FrequencyResponse
    bands: ResponseBands | None = None


def co_simulate(
    system: Path,
    per_cent: float | None = None,
    progress: Progress = silent,
    values: Mapping[str, float] | None = None,
) -> CoSimulated:
    """Co-simulate a system.

    Args:
        system: SYSTEM.toml.
        per_cent: that its bands are to hold, such as 95; None for none.
        progress: is told the share done.
        values: other values than the files state, by place, as a study varies them.

    Raises:
        UserError: the system can't be read, built or run, no law tells how sure it is, or a place isn't there.
        UsageError: the share can't be held by a band, or bands and other values are asked for together.
    """

    def tell(share: float) -> None:
        progress(f"{share:.0%}")

    if values and per_cent is not None:
        raise UsageError("--bands: follow from what the files state; expected no values beside them: write them there")
    if values:
        return CoSimulated(_run_with(system, values, tell))
    if per_cent is None:
        return CoSimulated(run_system(system, tell))
    # An ensemble is loaded for bands alone.
    from pipeclamp_system.bands.ensemble import refuse, run_bands

    refuse(system, per_cent)
    banded = run_bands(system, run_system(system, tell), per_cent, progress)
    return CoSimulated(banded.result, banded)


def _run_with(system: Path, values: Mapping[str, float], tell: ShareDone) -> CosimResult:
    """Co-simulate a system with other values than its files state."""
    # Studies are loaded for other values alone.
    from pipeclamp_system.study.case import run_varied
    from pipeclamp_system.study.description import described_with, refuse_places, tables_of

    read_system(system)
    refuse_places(values, str(system))
    described = described_with(*tables_of(system), values)
    return run_varied(*described, system.parent, str(system), tell)


def respond(
    system: Path,
    per_cent: float | None = None,
    limits: Mapping[str, float] | None = None,
    progress: Progress = silent,
) -> Responded:
    """Give the frequency response of a system.

    Args:
        system: SYSTEM.toml.
        per_cent: as of `co_simulate`.
        limits: mm that clamps or probes may move, by name: how likely they move farther is told with the bands.
        progress: is told what is being done.

    Raises:
        UserError: the system can't be read or built, has no sine, no law or nothing to show, or a co-simulation fails.
        UsageError: the share can't be held by a band, or a limit is for no clamp or probe, or without a band.
    """
    from pipeclamp_system.response.run import run_response

    if per_cent is None:
        if limits:
            raise UsageError(
                "--limit: how likely it is exceeded is told with --bands alone; expected --bands 95 beside it"
            )
        return Responded(run_response(system, progress))
    from pipeclamp_system.bands.response import refuse, response_bands

    refuse(system, per_cent, limits or {})
    found = run_response(system, progress)
    return Responded(found, response_bands(system, found, per_cent, limits, progress))
