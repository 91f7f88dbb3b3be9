"""Runs that the page starts, sees and stops: commands of their own, which go on when the page and its server end."""

from __future__ import annotations

import os
import platform
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

from assessment.runtime.errors import ProjectError
from assessment.runtime.journal import NAME as JOURNAL
from assessment.runtime.journal import Recorded, holder, progress_of, read_journal

TOLD = 2000  # letters of what a command that failed has said


class Runs:
    """The run in the output folder of a project, whoever has started it; `log`: where a command says what is wrong.

    The log is not in the project, whose disk may be full.
    """

    def __init__(self, folder: Path, log: Path) -> None:
        self.folder, self.output, self.log = folder, folder / "output", log
        self.process: subprocess.Popen[Any] | None = None
        self.seen: tuple[tuple[int, int] | None, Recorded] = (None, Recorded())

    def start(self, command: str, *options: str) -> None:
        """Start `assesto COMMAND` on the project. Raises ProjectError where one is at work, OSError where none can."""
        running = holder(self.output)
        if running or (self.process and self.process.poll() is None):
            raise ProjectError(
                f"{self.output}: {running.text if running else 'a command'} is at work; wait or stop it"
            )
        # no Ctrl-C of this terminal
        new: dict[str, Any] = {"creationflags": 0x208} if os.name == "nt" else {"start_new_session": True}
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "assessment.cli", command, str(self.folder), *options],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                **new,
            )

    def stop(self) -> None:
        """End the run as Ctrl-C does: what is finished is kept. Raises ProjectError where it is on another machine."""
        running = holder(self.output)
        pid = self.process.pid if self.process and self.process.poll() is None else running and running.pid
        if running and f"on {platform.node()} " not in running.text:
            raise ProjectError(f"{self.output}: {running.text}: stop it there")
        if pid:
            os.kill(pid, signal.SIGTERM)

    def state(self) -> dict[str, Any]:
        """Return where the run is: what `assesto status --json` prints, and what a command of the page has said."""
        code = self.process.poll() if self.process else None
        found = progress_of(self._recorded(), holder(self.output))
        own = self.process is not None and code is None
        said = "" if code in (None, 0) else self.log.read_text(encoding="utf-8", errors="replace")[-TOLD:]
        if found["exit_code"] is None and not own:
            found["exit_code"] = code  # of a command that has left no journal
        return found | {"running": found["running"] or own, "own": own, "said": said.strip()}

    def _recorded(self) -> Recorded:
        try:
            status = (self.output / JOURNAL).stat()
        except OSError:
            return Recorded()
        key = (status.st_mtime_ns, status.st_size)
        if self.seen[0] != key:
            self.seen = (key, read_journal(self.output))
        return self.seen[1]
