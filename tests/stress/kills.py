"""Kills a run at random moments and runs it again: `python -m tests.stress.kills [COUNT] [SEED]` prints the counts.

Each run is that of a small project with every stage, in two processes: into an empty folder, or over the whole results
of an earlier run with other increments. It is killed (SIGKILL) at a random moment of the time that an undisturbed one
takes, every third time the main process alone. After a kill

- what is there to see in the folder is as it was before, or as the new run leaves it, or without results.json;
- every analysis that is kept is whole, and none that was kept before is lost;
- the next run takes over all of them, and its results and tables are those of an undisturbed run to the last bit.
"""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from assessment.runtime.cache import FOLDER, Store
from tests import ROOT
from tests.support.block_project import contents, read_results, timeless
from tests.support.every_stage import write_every_stage

LOCK = ".assesto.lock"  # that a killed run leaves


@dataclass(frozen=True)
class Whole:
    """An undisturbed run: its products, results without times, duration (s) and analyses."""

    files: dict[str, str]
    results: Any
    seconds: float
    analyses: int


def command(project: Path, output: Path) -> Sequence[str]:
    options = ("--out", str(output), "--no-report", "--json", "--jobs", "2")
    return sys.executable, "-m", "assessment.cli", "run", str(project), *options


def seen(output: Path) -> dict[str, str]:
    """Products in a folder and their digests; results.json without times, hidden files apart."""
    found = {
        name: digest
        for name, digest in (contents(output) if output.is_dir() else {}).items()
        if not Path(name).parts[0].startswith(".")
    }
    if "results.json" in found:
        found["results.json"] = json.dumps(timeless(read_results(output)), sort_keys=True)
    return found


def kept(output: Path) -> set[str]:
    """Fingerprints of the analyses that are kept; raises AssertionError for one that is damaged."""
    store = Store(output / FOLDER)
    names = {path.name for path in store.folder.glob("[0-9a-f]*")} if store.folder.is_dir() else set()
    names = {name for name in names if len(name) == 64}
    assert all(store.read(name) is not None for name in names), "an analysis that is kept is damaged"
    return names


def undisturbed(project: Path, output: Path) -> Whole:
    began = time.perf_counter()
    done = subprocess.run(command(project, output), cwd=ROOT, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - began
    assert done.returncode == 0, done.stderr
    analyses = json.loads(done.stdout)["analyses"]
    files = seen(output)
    return Whole(
        files, timeless(read_results(output)), seconds, analyses["computed"] + analyses["taken_over"]
    )


def killed(project: Path, output: Path, moment: float, alone: bool) -> bool:
    """Begin a run, kill it after a moment (s), `alone`: without its processes; return whether it was still there."""
    with subprocess.Popen(
        command(project, output),
        cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    ) as run:  # fmt: skip
        time.sleep(moment)
        if run.poll() is not None:
            return False
        (os.kill if alone else os.killpg)(run.pid, signal.SIGKILL)
    return run.returncode == -signal.SIGKILL


def tried(count: int, seed: int, tell: Callable[[str], object] = lambda _: None) -> Counter[str]:
    """Kill so many runs, each followed by one that is left alone; raise AssertionError for anything lost.

    `tell`: is given the counts so far after each.
    """
    chance, counts = random.Random(seed), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        project, earlier = (write_every_stage(here / name) for name in ("new", "old"))
        text = (earlier / "project.toml").read_text(encoding="utf-8")
        assert "increment_m = 0.2" in text
        (earlier / "project.toml").write_text(text.replace("increment_m = 0.2", "increment_m = 0.1"), "utf-8")
        old = undisturbed(earlier, here / "before")
        new = undisturbed(project, here / "whole")
        longest = max(new.seconds, undisturbed(project, here / "again").seconds)
        assert seen(here / "again") == new.files, "two undisturbed runs differ"
        while counts["killed"] < count:
            output = here / "output"
            shutil.rmtree(output, ignore_errors=True)
            over = bool(counts["begun"] % 2)
            if over:
                shutil.copytree(here / "before", output)
            before, first = seen(output), kept(output)
            counts["begun"] += 1
            if not killed(project, output, chance.uniform(0.0, longest), alone=counts["begun"] % 3 == 0):
                counts["ended before"] += 1
                continue
            counts["killed"] += 1
            left, analyses = seen(output), kept(output)
            assert left in (before, new.files) or "results.json" not in left, "a mixture of old and new"
            assert before == (old.files if over else {})
            assert analyses >= first, "an analysis that was kept is lost"
            counts["over earlier results"] += over
            counts["new results in place"] += left == new.files
            counts["analyses kept"] += len(analyses - first)
            counts["within the analyses"] += 0 < len(analyses - first) < new.analyses
            done = subprocess.run(
                command(project, output), cwd=ROOT, capture_output=True, text=True, check=False
            )
            assert done.returncode == 0, done.stderr
            assert seen(output) == new.files, "the results differ"
            again = json.loads(done.stdout)["analyses"]
            assert again["taken_over"] >= len(analyses - first), "a kept analysis was computed again"
            assert kept(output) >= analyses and not (output / LOCK).exists()
            tell(f"sound: {dict(counts)}")
    return counts


if __name__ == "__main__":
    number, first = (int(text) for text in (*sys.argv[1:], *("60", "17")[len(sys.argv) - 1 :]))
    for name, value in tried(number, first, print).items():
        print(f"{name}: {value}")
