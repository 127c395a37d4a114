"""Pictures of the studio, wide and narrow, as docs/howto/studio.md shows them.

Run: python build_scripts/readme_pictures/studio.py        (pip install -e ".[studio,browser]" pillow)
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

import pipeclamp as pc

FOLDER = Path(__file__).parents[2] / "docs" / "pictures"
CAMPAIGN, EFFECT = "clamp_a", "damping_temperature"
RUN = "A0p2_f5_T20"
SIZES = {"studio": (1400, 1000), "studio_narrow": (420, 900)}
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
COLOURS = 200
"""Fewer make a file of half the size, and look the same."""
A_JOB_ms = 120_000


def prepared(home):
    """Write two laws, as the studio would."""
    tests = pc.read_campaign(CAMPAIGN)
    law = pc.identify(tests)
    home.mkdir()
    law.save(home / "law1.json")
    pc.add(law, EFFECT, tests).save(home / "law2.json")


def main():
    """Start a studio, diagnose its law and take the pictures."""
    with tempfile.TemporaryDirectory() as temporary:
        home = Path(temporary) / f"{CAMPAIGN}_studio"
        prepared(home)
        command = [sys.executable, "-m", "pipeclamp", "studio", CAMPAIGN, "-o", home.name, "--no-browser"]
        with subprocess.Popen(command, cwd=temporary, env=os.environ, stdout=subprocess.PIPE, text=True) as studio:
            url = studio.stdout.readline().strip()
            with sync_playwright() as playwright:
                chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
                page = chromium.new_page(viewport=dict(zip(("width", "height"), SIZES["studio"], strict=True)))
                page.goto(f"{url}&run={RUN}")
                page.click("text=Find what is missing")
                page.wait_for_selector("#candidates", timeout=A_JOB_ms)
                for name, (width, height) in SIZES.items():
                    page.set_viewport_size({"width": width, "height": height})
                    page.goto(f"{url}&run={RUN}")
                    page.wait_for_selector("#harmonics .main-svg")
                    if name == "studio":
                        page.evaluate("document.querySelector('input[name=candidate]').click()")
                        page.wait_for_selector("#errors :text('memory')")
                    page.wait_for_timeout(2000)
                    page.screenshot(path=FOLDER / f"{name}.png")
                    few = Image.open(FOLDER / f"{name}.png").convert("RGB").quantize(COLOURS)
                    few.save(FOLDER / f"{name}.png", optimize=True)
                chromium.close()
            studio.terminate()


if __name__ == "__main__":
    main()
