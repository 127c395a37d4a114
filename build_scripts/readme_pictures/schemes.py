"""Error against CPU time of the coupling schemes, as the benchmark measures them."""

import sys
import tempfile
from pathlib import Path

import plotly.graph_objects as go

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

from work_precision import measure, picture_of

HEIGHT = 520


def picture() -> go.Figure:
    """Draw the stiff case."""
    with tempfile.TemporaryDirectory() as folder:
        figure = picture_of(measure("stiff", Path(folder)), "")
    figure.update_layout(height=HEIGHT, font={"size": 15}, margin={"t": 20, "b": 90, "l": 80})
    return figure
