"""What a person waits for in the studio, measured in a browser on a 240-run campaign of 1.4 million rows.

Run: python build_scripts/benchmarks/studio_speed.py        (pip install -e ".[studio,browser]", and a Chromium)

From the address being printed to the first picture; from a click on the map to the loop; from a slider that is moved to
the loop; a click while a diagnosis runs. All clicks come without the pointer having rested on the cell, so that nothing
was fetched ahead.
"""

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from identify_speed import campaign_runs
from playwright.sync_api import sync_playwright

import pipeclamp as pc
from pipeclamp_identification.campaign.writing import write_campaign

FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
CLICKS = 40
CLICK = """async place => {
  const cells = [...document.querySelectorAll('.map .cell')];
  const cell = cells[(place * 37) % cells.length], run = cell.dataset.runs.split('|')[0];
  const begin = performance.now();
  cell.click();
  while (document.getElementById('run-title').textContent !== run) await new Promise(done => setTimeout(done, 1));
  await new Promise(done => requestAnimationFrame(done));
  return performance.now() - begin;
}"""
MOVE = """async place => {
  const slider = document.querySelector('input[data-parameter=k10]'), told = document.getElementById('errors');
  const before = told.textContent, begin = performance.now();
  slider.value = slider.dataset.fit * (1 + 0.01 * (place + 1));
  slider.dispatchEvent(new Event('input', { bubbles: true }));
  while (told.textContent === before) await new Promise(done => setTimeout(done, 1));
  return performance.now() - begin;
}"""


def told(name, taken):
    """Print the median and the longest of what was measured, in ms."""
    print(f"{name:32s} median {statistics.median(taken):4.0f} ms, longest {max(taken):4.0f} ms")


def main():
    """Make the campaign and its law, start the studio, and measure."""
    with tempfile.TemporaryDirectory() as temporary:
        folder, home = Path(temporary) / "speed", Path(temporary) / "home"
        count = write_campaign(folder, campaign_runs(), name="speed", notes="")
        home.mkdir()
        pc.identify(folder).save(home / "law1.json")
        command = [sys.executable, "-m", "pipeclamp", "studio", str(folder), "-o", str(home), "--no-browser"]
        begin = time.perf_counter()
        with (
            subprocess.Popen(command, env=os.environ, stdout=subprocess.PIPE, text=True) as studio,
            sync_playwright() as playwright,
        ):
            chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
            page = chromium.new_page(viewport={"width": 1400, "height": 1000})
            url = studio.stdout.readline().strip()
            print(f"{count} runs; started and read in {time.perf_counter() - begin:.1f} s")
            begin = time.perf_counter()
            page.goto(url)
            page.wait_for_selector("#loop .main-svg")
            print(f"first picture after {time.perf_counter() - begin:.2f} s")
            page.wait_for_timeout(1000)
            told("click to loop", [page.evaluate(CLICK, place) for place in range(1, CLICKS)])
            told("slider to loop", [page.evaluate(MOVE, place) for place in range(CLICKS)])
            page.click("text=Find what is missing")
            page.wait_for_selector(".job progress")
            page.wait_for_timeout(3000)
            told("click while a diagnosis runs", [page.evaluate(CLICK, place) for place in range(CLICKS, 2 * CLICKS)])
            page.click("text=Cancel")
            page.wait_for_selector("text=cancelled")
            chromium.close()
            studio.terminate()


if __name__ == "__main__":
    main()
