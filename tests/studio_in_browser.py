"""A studio that is started as a user does, and what tests of it in a browser ask its pages."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import contextmanager

NARROW = {"width": 420, "height": 900}
LOOP = "#loop .main-svg"
A_JOB_ms = 120_000


@contextmanager
def studio_of(campaign, home):
    """Run a studio and give its address."""
    command = [sys.executable, "-m", "pipeclamp", "studio", campaign, "-o", str(home), "--no-browser"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, encoding="utf-8") as process:
        try:
            yield process.stdout.readline().strip()
        finally:
            process.terminate()


def no_wider_than_the_window(page):
    return page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def soon_no_wider_than_the_window(page):
    """Tell so once pictures have been drawn anew, which takes a moment."""
    for _ in range(50):
        if no_wider_than_the_window(page):
            return True
        page.wait_for_timeout(100)
    return False
