"""Pictures of the README and the pages, as PNG in docs/pictures/.

Run: python build_scripts/readme_pictures/run.py [law_grows] [response] [schemes]        (all of them unless told)

Needs a Chromium, which turns pages into pictures.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import law_grows
import plotly.graph_objects as go
import response
import schemes

FOLDER = Path(__file__).parents[2] / "docs" / "pictures"
WIDTH = 1080
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome", "msedge")
PICTURES = {"law_grows": law_grows.picture, "response": response.picture, "schemes": schemes.picture}


def save(browser: str, figure: go.Figure, output: Path) -> None:
    """Let a browser turn a figure into a PNG."""
    figure.update_layout(width=WIDTH)
    with tempfile.TemporaryDirectory() as temporary:
        page = Path(temporary) / "picture.html"
        body = figure.to_html(full_html=False, include_plotlyjs=True, config={"displayModeBar": False})
        page.write_text(f"<!DOCTYPE html><meta charset='utf-8'><body style='margin:0'>{body}</body>", encoding="utf-8")
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=4000"]
        subprocess.run(
            [browser, *options, f"--user-data-dir={temporary}/profile",
             f"--window-size={WIDTH},{figure.layout.height}", f"--screenshot={output}", page.as_uri()],
            check=True, capture_output=True, timeout=120,
        )  # fmt: skip
    print(f"{output}: {output.stat().st_size / 1024:.0f} kB")


def main() -> None:
    """Draw the pictures that were named."""
    browser = next((path for path in map(shutil.which, BROWSERS) if path), None)
    if browser is None:
        sys.exit(f"no browser found; expected one of {', '.join(BROWSERS)} on the path")
    names = sys.argv[1:] or list(PICTURES)
    if unknown := [name for name in names if name not in PICTURES]:
        sys.exit(f"no picture {unknown[0]!r}; expected some of {', '.join(PICTURES)}")
    FOLDER.mkdir(exist_ok=True)
    for name in names:
        save(browser, PICTURES[name](), FOLDER / f"{name}.png")


if __name__ == "__main__":
    main()
