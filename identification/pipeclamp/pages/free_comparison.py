"""The part of a comparison's page that tells of free motions."""

from __future__ import annotations

from pipeclamp.pages.error_pictures import bars_of, error_bars
from pipeclamp.pages.free_pictures import over_time_picture, path_picture
from pipeclamp.pages.page import Section
from pipeclamp.show.comparison import beside_even, free_table, parts_table
from pipeclamp_identification.comparison import free_breakdown
from pipeclamp_identification.comparison.compare import Comparison

DRAWN = 4
"""Runs that are drawn, worst first."""

FOLLOWED = (
    "The law follows each motion from rest. Its memory is unloaded where the record begins, unless the force at rest "
    "tells of a past: then the law is brought there from the nearest place that explains that force. A and f are "
    "tracked from what has passed of the motion, as an FMU with track = true does, and held inside the law's range."
)
EVEN = beside_even("every run erred by the same part of its force all the time")


def free_sections(comparison: Comparison) -> list[Section]:
    """Give the sections on free motions; none where there are none."""
    if not comparison.free:
        return []
    samples = comparison.free_samples
    named = [free_breakdown.by_free_place(samples), free_breakdown.by_direction(samples)]
    numbered = [
        free_breakdown.by_time(samples),
        *(free_breakdown.by_class(samples, classes) for classes in free_breakdown.motion_classes(samples)),
        *(free_breakdown.by_free_condition(samples, condition) for condition in comparison.free_varied),
    ]
    figures = []
    for run in comparison.worst_free_first()[:DRAWN]:
        title = f"{run.run}: error {100 * run.nrmse:.3g}%"
        figures += [over_time_picture(run, title), path_picture(run, f"{run.run}: force over displacement")]
    bars = [
        error_bars([bars_of("", parts.by, parts) for parts in broken], f"{what}, percent of the rms force")
        for what, broken in (("Between turning points", named), ("Over time and by what the motion does", numbered))
    ]
    tables = [parts_table(parts, runs=True) for parts in (*named, *numbered)]
    components = parts_table(free_breakdown.by_component(samples), even=False)
    return [
        Section("Free motions", [FOLLOWED], [free_table(comparison)], figures),
        Section("Where along free motions", [EVEN], [components, *tables], bars),
    ]
