"""What an effect does to a clamp's loops, drawn from its own equation."""

from __future__ import annotations

from collections.abc import Sequence

import plotly.graph_objects as go

from pipeclamp.pages.pictures import LoopPanel, loops_picture
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.realise.effect_loops import loops_with_and_without


def sketch(name: str, effect: Effect, declared: Sequence[Declaration] = ()) -> go.Figure:
    """Draw what an effect of typical size does to a clamp's loops, from its own equation."""
    loops = loops_with_and_without(effect, declared)
    panels = [
        LoopPanel(label, y, without, with_it)
        for label, y, without, with_it in zip(
            loops.labels, loops.displacement, loops.without, loops.with_it, strict=True
        )
    ]
    larger = f", drawn {loops.times} times as large" if loops.times > 1 else ""
    return loops_picture(
        panels, f"{name} of typical size on a loop: without (grey), with (red){larger}", names=("without", "with")
    )
