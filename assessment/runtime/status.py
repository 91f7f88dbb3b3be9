"""What the run in an output folder is at, or how the last one ended, as text and as JSON."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from assessment.runtime.files.lock import Holder, holder
from assessment.runtime.journal import Recorded, Stage, read_journal
from assessment.runtime.progress import clock, time_left


def status(folder: Path) -> str:
    """Return the stages of the last run in a folder: done, failed with reasons, in flight, time left."""
    recorded, running = read_journal(folder), holder(folder)
    if not running and not recorded.stages and recorded.exit_code is None:
        stored = folder / "results.json"
        return (
            f"results of an earlier run: {stored}"
            if stored.is_file()
            else f"nothing has been run in {folder}"
        )
    lines = [_headline(recorded, running, folder)]
    for stage in recorded.stages:
        lines.append(_line(stage, running is not None))
        lines += [f"  failed: {title}: {reason}" for title, reasons in stage.faults for reason in reasons]
    if not running and recorded.exit_code != 0:
        lines.append("finished analyses are kept: run again to go on")
    return "\n".join(lines)


def status_json(folder: Path) -> str:
    """Return the same as one JSON object, the keys as docs/howto/run.md has them."""
    return json.dumps(progress_of(read_journal(folder), holder(folder)), indent=2)


def progress_of(recorded: Recorded, running: Holder | None) -> dict[str, Any]:
    """Return where a run is, as its journal and its lock tell: plain values.

    `stage`, `done`, `total` (analyses), `under_way` and `seconds_left` are of the last stage, `failed` of all stages.
    """
    stage = recorded.stages[-1] if recorded.stages else None
    at_work = running is not None and stage is not None and not stage.ended
    left = stage.pace.left(time.time()) if stage and at_work else None
    return {
        "running": running is not None,
        "pid": running.pid if running else None,
        "exit_code": None if running else recorded.exit_code,
        "stage": stage.name if stage else None,
        "done": stage.taken + stage.done if stage else 0,
        "total": stage.total if stage else 0,
        "failed": sum(len(each.faults) for each in recorded.stages),
        "under_way": stage.under_way if stage and at_work else None,
        "seconds_left": None if left is None else max(0.0, left),
        "stages": [
            {
                "stage": each.name,
                "done": each.taken + each.done,
                "taken_over": each.taken,
                "total": each.total,
                "ended": each.ended,
                "failures": [{"title": title, "reasons": reasons} for title, reasons in each.faults],
            }
            for each in recorded.stages
        ],
    }


def _headline(recorded: Recorded, running: Holder | None, folder: Path) -> str:
    if running:
        return f"at work: {running.text}"
    if recorded.exit_code is None or any(not stage.ended for stage in recorded.stages):
        return "not at work: the run was interrupted or killed"
    return f"finished: {folder}" + (f", exit code {recorded.exit_code}" if recorded.exit_code else "")


def _line(stage: Stage, running: bool) -> str:
    text = f"{stage.name}: {stage.taken + stage.done} of {stage.total} done"
    if stage.taken:
        text += f" ({stage.taken} taken over)"
    if stage.faults:
        text += f", {len(stage.faults)} failed"
    if stage.ended or not running:
        return text
    now = time.time()
    left = time_left(stage.pace, now, "not known yet")
    text += f", {stage.open} in flight or waiting; {clock(now - stage.pace.began)} gone, left: {left}"
    return f"{text}; at {stage.under_way}" if stage.under_way else text
