"""The page in the browser: how long it takes to be there, to draw a model, to follow a support, and to draw a frame."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from assessment.app.editing import drawing_tag
from assessment.app.worker import Worker
from assessment.benchmark.table import Row
from assessment.project.catalogue.new_project import new_project
from assessment.project.project import load_project

ROUNDS = 5  # of which the median is told
ANSWERS = 30  # of a support that is led to and fro
MOVES = 120  # of the pointer
WATCH = """(() => {
  window.gaps = []; window.watching = true;
  const next = (last) => requestAnimationFrame((now) => { gaps.push(now - last); if (watching) next(now); });
  next(performance.now());
})()"""


def latencies(quick: bool) -> Iterator[Row]:
    """Rows of an arch of 33 blocks and, not where it is to be quick, of a triumphal arch of 367."""
    with TemporaryDirectory() as folder:
        for template in ("buttressed-arch", *(() if quick else ("triumphal-arch",))):
            project = Path(folder) / template
            new_project(project, template, {})
            waited = [_to_page(project) for _ in range(ROUNDS)]
            yield _latency(template, "from the command to the page", waited)
            yield from _of_the_worker(project, template)
            yield from _frames(project, template)


def _latency(case: str, what: str, seconds: list[float]) -> Row:
    return {"case": case, "what": what, "seconds": float(np.median(seconds)), "largest": max(seconds)}


def _to_page(project: Path) -> float:
    """Time from `assesto app` until the page is answered."""
    began = time.perf_counter()
    with _served(project) as address:
        urllib.request.urlopen(address).read()
        return time.perf_counter() - began


@contextmanager
def _served(project: Path) -> Iterator[str]:
    """Yield the address of a server of its own."""
    command = [sys.executable, "-m", "assessment.cli", "app", str(project), "--no-browser"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        assert server.stdout is not None
        yield server.stdout.readline().strip()
    finally:
        server.terminate()
        server.wait()


def _of_the_worker(project: Path, case: str) -> Iterator[Row]:
    """Time of what the process beside the server answers: the model, first and again, and a support that is led."""
    first, again = [], []
    for _ in range(ROUNDS):
        worker = Worker()
        first.append(_asked(worker, "model", folder=project))
        again.append(_asked(worker, "model", folder=project))
        worker.end()
    yield _latency(case, "the model, with the start of the process", first)
    yield _latency(case, "the model again", again)
    worker, content = Worker(), load_project(project)
    moved = content.settlements[0]
    target = np.array([*moved.displacement_m, 0.0])
    given = {"folder": project, "tag": drawing_tag(content), "support": moved.support}
    _asked(worker, "live", **given, target=(0.1 * target).tolist(), home=True)
    # by what a pointer moves in a frame or two
    ways = [0.1 + 0.05 * abs((k + 5) % 10 - 5) for k in range(ANSWERS)]
    led = [_asked(worker, "live", **given, target=(share * target).tolist()) for share in ways]
    yield _latency(case, "an answer to a support that is dragged", led)
    whole = [_asked(worker, "live", **given, target=target.tolist(), whole=True) for _ in range(ROUNDS)]
    yield _latency(case, "the straight way on release", whole)
    worker.end()


def _frames(project: Path, case: str) -> Iterator[Row]:
    """Time of a frame as the pointer goes over the drawing, moves, enlarges and encircles it; joints are shown.

    No rows where there is no Chromium or Playwright to drive it.
    """
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if chromium is None or find_spec("playwright") is None:
        return
    from playwright.sync_api import sync_playwright

    ways = {"hover": "select", "pan": "select", "zoom": "select", "lasso": "lasso"}
    with _served(project) as address, sync_playwright() as tools:
        browser = tools.chromium.launch(executable_path=chromium, args=["--headless", "--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(address)
        page.wait_for_selector("body[data-model=shown]")
        page.click("[data-tool=joints]")
        box = page.locator("#drawing").bounding_box()
        assert box is not None
        for what, tool in ways.items():
            page.click(f"[data-tool={tool}]")
            page.evaluate(WATCH)
            for k in range(MOVES):
                angle = 2.0 * np.pi * k / MOVES
                x, y = box["width"] * (0.5 + 0.2 * np.cos(angle)), box["height"] * (0.5 + 0.2 * np.sin(angle))
                page.mouse.move(box["x"] + x, box["y"] + y)
                if k == 0 and what in ("pan", "lasso"):
                    page.mouse.down()
                if what == "zoom":
                    page.mouse.wheel(0, -100 if k % 2 else 100)
            page.mouse.up()
            gaps = page.evaluate("(() => { watching = false; return gaps.slice(1); })()")
            yield _latency(case, f"a frame, {what}", [1e-3 * gap for gap in gaps])
        browser.close()


def _asked(worker: Worker, question: str, **given: object) -> float:
    began = time.perf_counter()
    worker.ask(question, **given)
    return time.perf_counter() - began
