"""The loops of a clamp with and without an effect, drawn."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.realise.effect_loops import EffectLoops, loops_with_and_without

mpl.use("svg")
from matplotlib.figure import Figure

WITHOUT, WITH = "#52606d", "#d64545"


def draw(effect: Effect, path: Path) -> EffectLoops:
    """Draw the loops side by side, on one scale, into an SVG file; give what was drawn."""
    loops = loops_with_and_without(effect)
    with mpl.rc_context(
        {"svg.hashsalt": effect.id, "svg.fonttype": "path", "font.family": "DejaVu Sans", "font.size": 9}
    ):
        figure = Figure(figsize=(8.0, 2.9), layout="constrained")
        panels = figure.subplots(1, len(loops.labels), sharex=True, sharey=True)
        for row, (panel, label) in enumerate(zip(panels, loops.labels, strict=True)):
            y = np.append(loops.displacement[row], loops.displacement[row, 0])
            for force, colour, name in ((loops.without, WITHOUT, "without"), (loops.with_it, WITH, "with")):
                closed = np.append(force[row], force[row, 0])
                panel.plot(y, closed, color=colour, linewidth=1.4, label=name)
            panel.set_title(label, fontsize=9)
            panel.set_xlabel("y / mm")
            panel.grid(color="#e4e7eb", linewidth=0.6)
            panel.spines[["top", "right"]].set_visible(False)
        panels[0].set_ylabel("F / N")
        panels[0].legend(frameon=False, loc="upper left", fontsize=8)
        figure.savefig(path, format="svg", metadata={"Date": None}, facecolor="white")
    return loops
