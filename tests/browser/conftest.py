"""A real browser for tests: Chromium by Playwright; without either, the tests that need it skip by name."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from studio_in_browser import studio_of

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip
WIDE, NARROW = {"width": 1400, "height": 1000}, {"width": 420, "height": 900}


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Give Chromium, without a window."""
    playwright = pytest.importorskip("playwright.sync_api", reason="needs the extra 'browser'")
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(f"needs a browser: {' or '.join(NAMES)}")
    with playwright.sync_playwright() as started:
        chromium = started.chromium.launch(executable_path=path, args=list(FLAGS))
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser: Any) -> Iterator[Any]:
    """Give an empty page, wide; whatever it complains of on its console fails the test."""
    context = browser.new_context(viewport=WIDE)
    opened, complaints = context.new_page(), []
    opened.on("console", lambda told: complaints.append(told.text) if told.type in ("error", "warning") else None)
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    yield opened
    context.close()
    assert not complaints


@pytest.fixture(scope="session")
def violations() -> Callable[[Any], list[str]]:
    """Give a function that says where a page is closed to somebody, as axe-core finds it."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="needs the extra 'browser'").Axe()

    def found(opened: Any) -> list[str]:
        return [
            f"{each['id']}: {each['help']}: {[node['html'][:160] for node in each['nodes']][:3]}"
            for each in axe.run(opened).response["violations"]
        ]

    return found


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give the folder that the studio of a file of tests keeps its laws in."""
    return tmp_path_factory.mktemp("studio") / "home"


@pytest.fixture(scope="module")
def url(home: Path) -> Iterator[str]:
    """Give the address of a studio of clamp_a."""
    with studio_of("clamp_a", home) as address:
        yield address
