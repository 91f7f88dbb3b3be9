"""The progress or outcome of the run in an output folder, as text."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from assessment.runtime.files.journal import Stage, read_journal
from assessment.runtime.files.lock import holder
from assessment.runtime.terminal.progress import LATE, OVER


def status(folder: Path) -> str:
    """Return the stages of the run in a folder: done, failed, in flight, time left; failures with their reasons.

    Of a run that has ended, what its results hold. Raises ValueError, naming file and key, where they are damaged.
    """
    stages, running = read_journal(folder), holder(folder)
    if not stages and not running:
        return "\n".join(_finished(folder))
    lines = [f"at work: {running}" if running else "not at work: the run was interrupted or killed"]
    for stage in stages:
        lines.append(_line(stage, bool(running)))
        lines += _faults(stage.faults)
    if not running:
        lines.append("finished analyses are kept: run again to go on")
    return "\n".join(lines)


def _line(stage: Stage, running: bool) -> str:
    text = f"{stage.name}: {stage.taken + stage.done} of {stage.total} done"
    if stage.taken:
        text += f" ({stage.taken} taken over)"
    if stage.faults:
        text += f", {len(stage.faults)} failed"
    if stage.ended or not running:
        return text
    now, ends = time.time(), stage.pace.ends
    left = "not known yet" if ends is None else LATE if ends < now - OVER else _clock(max(0.0, ends - now))
    return f"{text}, {stage.open} in flight or waiting; {_clock(now - stage.pace.began)} gone, left: {left}"


def _finished(folder: Path) -> Iterator[str]:
    from assessment.results.file import read_results  # late: not needed for a run under way

    stored = folder / "results.json"
    if not stored.is_file():
        yield f"nothing has been run in {folder}"
        return
    results = read_results(stored)
    failures = (results.campaign and results.campaign.failures) or []
    campaign = f", {len(failures)} failures of the campaign" if results.campaign else ""
    yield f"finished: {folder}, {results.quality.solves} solves{campaign}"
    yield from (f"  failed: {failure}" for failure in failures)


def _faults(faults: Sequence[tuple[str, list[str]]]) -> list[str]:
    return [f"  failed: {title}: {reason}" for title, reasons in faults for reason in reasons]


def _clock(seconds: float) -> str:
    whole = round(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"
