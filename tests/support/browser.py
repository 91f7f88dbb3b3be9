"""A headless Chromium driven by playwright: `import browser` makes it a fixture of a module of tests."""

import shutil
from collections.abc import Iterator
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = [
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
]
PATIENCE = 180_000  # ms, of a browser on a machine that does other things too


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """The browser; tests that ask for it are skipped where it or playwright is not installed."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="needs playwright: pip install -e '.[dev]'"
    )
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip("needs Chromium: apt-get install chromium")
    with playwright.sync_playwright() as tools:
        found = tools.chromium.launch(executable_path=path, args=OPTIONS)
        yield found
        found.close()
