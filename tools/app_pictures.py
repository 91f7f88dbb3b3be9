"""Pictures of the page in the browser for docs/app.md and its Italian twin, taken in Chromium.

The structures are those of `projects`, copied into a folder of their own; the second one is computed first.
"""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import Page, sync_playwright

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs" / "pictures"
OPTIONS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]
OPTIONS += ["--disable-background-networking", "--disable-component-update", "--disable-sync"]
COMMAND = [sys.executable, "-m", "assessment.cli"]


def main() -> None:
    """Take every picture in both languages."""
    with TemporaryDirectory() as home, sync_playwright() as tools:
        browser = tools.chromium.launch(executable_path=shutil.which("chromium"), args=OPTIONS)
        for name in ("triumphal_arch", "buttressed_arch"):
            ignored = shutil.ignore_patterns("output", ".assesto")
            shutil.copytree(ROOT / "projects" / name, Path(home) / name, ignore=ignored)
        run = [*COMMAND, "run", str(Path(home) / "buttressed_arch"), "--only", "pushdown,assessment"]
        subprocess.run(run, cwd=ROOT, check=True)
        for language in ("en", "it"):
            page = browser.new_context(viewport={"width": 1280, "height": 760}).new_page()
            page.set_default_timeout(120_000)
            for name, stages in (
                ("triumphal_arch", (drawing, movement, earthquake)),
                ("buttressed_arch", (results,)),
            ):
                with served(Path(home) / name) as address:
                    page.goto(address)
                    page.wait_for_selector("body[data-model=shown]")
                    if page.get_attribute("html", "lang") != language:
                        page.click("#language")
                    for stage in stages:
                        stage(page)
                        keep(page, f"app-{stage.__name__}-{language}.png")
        browser.close()


@contextmanager
def served(project: Path) -> Iterator[str]:
    """Yield the address of the page of a project."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    server = subprocess.Popen(
        [*COMMAND, "app", str(project), "--no-browser"], env=environment, stdout=subprocess.PIPE, text=True
    )
    assert server.stdout is not None
    yield server.stdout.readline().strip()
    server.terminate()
    server.wait()


def drawing(page: Page) -> None:
    """A layer is chosen."""
    page.click("[data-block='150']")
    page.wait_for_selector("#panel h2")


def movement(page: Page) -> None:
    """A support is dragged."""
    page.press("#drawing", "Escape")
    page.click("[data-step=settlements]")
    page.hover("[data-block='1']")
    page.mouse.down()
    box = page.locator("[data-block='1']").bounding_box()
    assert box is not None
    for k in range(1, 13):
        page.mouse.move(box["x"] + box["width"] / 2 + k, box["y"] + box["height"] / 2 + k)
        page.wait_for_timeout(400)
    page.mouse.up()
    page.wait_for_selector("#drawing[data-settled=written]")


def earthquake(page: Page) -> None:
    """The record over the spectra of the site."""
    page.click("[data-step=earthquake]")
    page.wait_for_selector("#wide figure >> nth=1")
    page.wait_for_timeout(1000)


def results(page: Page) -> None:
    """The summary, and the structure at a point of a curve."""
    page.click("[data-step=results]")
    page.frame_locator("#report-frame").locator("#viewer-frame").fill("10")
    page.wait_for_timeout(1000)


def keep(page: Page, name: str) -> None:
    """Write the window in few colours, which is a third of the bytes."""
    shown = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    shown.quantize(64).save(FOLDER / name, optimize=True)


if __name__ == "__main__":
    main()
