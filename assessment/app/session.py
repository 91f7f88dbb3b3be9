"""What the server knows of a project: its file with versions, results, and the runs, which outlive the server."""

from __future__ import annotations

import copy
import hashlib
import json
import os
import platform
import signal
import subprocess
import sys
import tempfile
import threading
import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from assessment.app.worker import Worker
from assessment.project.problems import project_error, schema_problems
from assessment.project.project import SOURCES, TOML, Project, project_file, spelt, survey_project
from assessment.project.schema import KeyPath, ProjectContent, alternatives, annotation_at
from assessment.project.toml import read_toml
from assessment.runtime.errors import ProjectError, error_text
from assessment.runtime.files import write_atomically
from assessment.runtime.progress import holder, progress_of, read_journal

OWN = ".assesto"  # folder beside project.toml: versions of it, where the page is, what was dropped
VERSIONS = 200  # that are kept
Change = tuple[KeyPath, Any]
"""Where a value stands and what it becomes; None: it is deleted, an entry of a list with its place."""


class ConflictError(Exception):
    """The file is not the one that the change was made in, or the project not the one that was asked of."""


def digest_of(content: bytes) -> str:
    """Return the digest by which a page knows a version of the project file."""
    return hashlib.sha256(content).hexdigest()[:16]


def model_tag(project: Project) -> str:
    """Return the digest by which a page knows a drawing and all that a run reads; of files as far as all are there."""
    with suppress(OSError, ValueError):
        return tags_of(spelt(project.echoed()), project.digests())["numbers"]
    return tags_of(spelt(project.echoed()), {})["numbers"]


def tags_of(content: Mapping[str, Any], inputs: Mapping[str, str]) -> dict[str, str]:
    """Return digests of what numbers follow from, and of what is printed with them; `inputs`: digests of the files."""
    page = {key: content[key] for key in ("title", "report")}
    numbers = [
        {**content, **dict.fromkeys(page)},
        [item for item in inputs.items() if item[0] not in SOURCES],
    ]
    read = {"numbers": numbers, "page": page}
    return {key: digest_of(json.dumps(each, sort_keys=True).encode()) for key, each in read.items()}


def edited(text: str, changes: Sequence[Change]) -> str:
    """Return the TOML text with all changes made; comments, order and all else stay as they are written.

    Raises ProjectError, a line per problem, for wrong keys, types, ranges or places.
    """
    import tomlkit

    document: Any = tomlkit.parse(text)
    content = tomllib.loads(text)
    for path, value in changes:
        try:
            # a page, whose JSON has no infinity, writes it as a text
            unbounded = value in ("inf", "-inf") and float in alternatives(annotation_at(path))
            given = float(value) if unbounded else value
            for node in (content, document):
                with suppress(ValueError):  # null within has no form in TOML, and is refused below
                    _delete(node, path) if given is None else _set(node, path, copy.deepcopy(given))
        except (LookupError, TypeError, AttributeError):
            raise ProjectError(f"{TOML}: {'.'.join(map(str, path))}: there is no such place") from None
    try:
        ProjectContent.model_validate(content)
    except ValidationError as error:
        raise project_error(TOML, schema_problems(error, content), {}) from None
    changed = tomlkit.dumps(document)
    said, asked = (json.dumps(it, sort_keys=True, default=str) for it in (tomllib.loads(changed), content))
    if said != asked:
        raise RuntimeError(f"{TOML}: the text does not say what was asked for")
    return changed


def _set(node: Any, path: KeyPath, value: Any) -> None:
    """Set what stands at a path, with the tables and lists on the way that are not there."""
    keys: list[Any] = [*path]
    while len(keys) > 1 and (keys[0] < len(node) if isinstance(keys[0], int) else keys[0] in node):
        node = node[keys.pop(0)]
    for part in reversed(keys[1:]):
        value = [value] if part == 0 else {part: value}
    key = keys[0]
    if isinstance(key, int) and key == len(node):
        node.append(value)
    # what agrees stays as it is written; True is not 1
    elif isinstance(key, int) or key not in node or node[key] != value or isinstance(value, bool):
        node[key] = value


def _delete(node: Any, path: KeyPath) -> None:
    """Delete what stands at a path, and the key of a list with its last entry."""
    with suppress(KeyError, IndexError):
        parent = node
        for part in path[:-1]:
            parent = parent[part]
        del parent[path[-1]]
        if isinstance(parent, list) and not parent:
            _delete(node, path[:-1])


class Versions:
    """The versions of a project file, `NNNN.toml` in a folder of their own, and which of them is the present one."""

    def __init__(self, folder: Path) -> None:
        self.file, self.folder = folder / TOML, folder / OWN / "history"

    def write(self, changes: Sequence[Change], digest: str) -> str:
        """Make changes in the file whose digest the page knew; return its new digest.

        Raises ConflictError, ProjectError as `edited` and for no TOML, or OSError: nothing is changed then.
        """
        before = self._known(digest)
        read_toml(self.file)  # what is refused here is nothing to parse
        after = edited(before.decode("utf-8-sig"), changes).encode()
        if after != before:
            self._go_to(self._added(self.taken_in(before), after))
        return digest_of(after)

    def step(self, by: int, digest: str | None) -> str:
        """Go back (-1) or forward (1) by a version, to the byte; return the digest of the file.

        What was changed elsewhere is taken in as a version first; a file that was taken away comes back as it was.
        Raises ConflictError as `write`, ProjectError where there is no such version.
        """
        to = self.taken_in(self._known(digest)) + by if self.file.exists() else self._at()
        if to not in self._versions():
            raise ProjectError(f"{TOML}: nothing to {'undo' if by < 0 else 'redo'}")
        return digest_of(self._go_to(to))

    def steps(self) -> tuple[bool, bool]:
        """Return whether there is a version to go back to, and one to go forward to."""
        versions, at = self._versions(), self._at()
        known = at in versions
        same = known and self.file.is_file() and self._path(at).read_bytes() == self.file.read_bytes()
        return known and (not same or at - 1 in versions), same and at + 1 in versions

    def _known(self, digest: str | None) -> bytes:
        content = self.file.read_bytes()
        if digest_of(content) != digest:
            raise ConflictError(f"{TOML} was changed elsewhere")
        return content

    def taken_in(self, present: bytes) -> int:
        """Return the number of the present version, which is made one where it is not the one at which undo is."""
        at = self._at()
        if at in self._versions() and self._path(at).read_bytes() == present:
            return at
        write_atomically(self.folder / "at", str(number := self._added(at, present)).encode())
        return number

    def _added(self, at: int, content: bytes) -> int:
        """Keep a version after another one, in the place of those that came after it; return its number."""
        write_atomically(self._path(at + 1), content)  # first: on a full disk no other version goes
        for version in self._versions():
            if version > at + 1 or version <= at + 1 - VERSIONS:
                self._path(version).unlink()
        return at + 1

    def _go_to(self, number: int) -> bytes:
        content = self._path(number).read_bytes()
        write_atomically(self.file, content)
        write_atomically(self.folder / "at", str(number).encode())
        return content

    def _at(self) -> int:
        """Return the number of the version that undo is at, 0 where there is none."""
        with suppress(OSError, ValueError):
            return int((self.folder / "at").read_bytes())
        return 0

    def _versions(self) -> list[int]:
        return sorted(int(path.stem) for path in self.folder.glob("*.toml") if path.stem.isdecimal())

    def _path(self, number: int) -> Path:
        return self.folder / f"{number:04}.toml"


SAID = 2000  # letters of what a command that failed has said


class Runs:
    """The run in the output folder of a project, whoever has started it; `log`: where a command says what is wrong.

    The log is not in the project, whose disk may be full.
    """

    def __init__(self, folder: Path, log: Path) -> None:
        self.folder, self.output, self.log = folder, folder / "output", log
        self.process: subprocess.Popen[Any] | None = None

    def start(self, command: str, *options: str) -> None:
        """Start `assesto COMMAND` on the project. Raises ProjectError where one is at work, OSError where none can."""
        running = holder(self.output)
        if running or (self.process and self.process.poll() is None):
            busy = running.text if running else "a command"
            raise ProjectError(f"{self.output}: {busy} is at work; wait or stop it")
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
        recorded = read_journal(self.output)
        found = progress_of(recorded, holder(self.output))
        own = self.process is not None and code is None
        said = "" if code in (None, 0) else self.log.read_text(encoding="utf-8", errors="replace")[-SAID:]
        if found["exit_code"] is None and not own and not recorded.stages:  # else: of another run, cut short
            found["exit_code"] = code  # of a command that has left no journal
        return found | {"running": found["running"] or own, "own": own, "said": said.strip()}


PLACES = {  # of a dropped file: suffixes, and the folder that it is put into
    "drawing": ((".dxf",), ""),
    "record": ((".acc", ".asc", ".at2", ".csv", ".txt", ".dat"), "records"),
    "grid": ((".txt", ".csv"), ""),
    "picture": ((".png", ".jpg", ".jpeg"), ""),
}
REPORTS = ("report.html", "report.pdf", "report.docx")


class Opened:
    """A project folder that is open: its file and versions, its runs and results."""

    def __init__(self, folder: Path, staging: Path) -> None:
        self.tag = digest_of(str(folder).encode())  # by which the page knows which project it shows
        self.folder, self.history = folder, Versions(folder)
        self.runs = Runs(folder, staging / f"{self.tag}.log")
        self._known: tuple[Any, dict[str, Any]] = (None, {})
        self._stored: tuple[int, dict[str, Any], dict[str, str]] = (0, {}, {})

    def state(self) -> dict[str, Any]:
        """Return content and problems of the file, the run, the results."""
        stamp = self._stamp()
        if self._known[0] != stamp:
            self._known = (stamp, self._read())
        undo, redo = self.history.steps()
        results = self._results(self._known[1]["tags"])
        return self._known[1] | {"undo": undo, "redo": redo, "run": self.runs.state(), "results": results}

    def _read(self) -> dict[str, Any]:
        """Return content and problems of the project file, a version from now on; `inputs`: digests of its files."""
        found = dict.fromkeys(("content", "error", "tag", "inputs", "digest", "source")) | {"tags": {}}
        found |= {"folder": str(self.folder), "project": self.tag, "problems": []}
        try:
            file = project_file(self.folder)
            found |= {"source": file.name, "digest": digest_of(file.read_bytes())}
            project, contradictions = survey_project(file)
        except (ProjectError, OSError) as error:
            return found | {"error": error_text(error)}
        with suppress(OSError):  # a spreadsheet, or a folder that is not to be written, has no versions
            self.history.taken_in(self.history.file.read_bytes())
        with suppress(OSError, ValueError):
            found["inputs"] = project.digests()
        tags = tags_of(spelt(project.echoed()), found["inputs"] or {})
        found |= {"tag": tags["numbers"], "tags": tags}
        return found | {
            "content": spelt(project.content(defaults=False)),
            "language": project.report.language,
            "problems": str(contradictions).split("\n") if contradictions else [],
        }

    def _results(self, tags: dict[str, str]) -> dict[str, Any] | None:
        """Return the summary of the last results, and `stale`, which of the tags is another; None: there are none."""
        output = self.folder / "output"
        try:
            stamp = (output / "results.json").stat().st_mtime_ns
            if self._stored[0] != stamp:
                results = json.loads((output / "results.json").read_bytes())
                told = {key: results[key] for key in ("summary", "timing_s")}
                self._stored = (stamp, told, tags_of(results["echo"], results["inputs"]))
        except (OSError, ValueError, AttributeError, LookupError, TypeError, RecursionError):  # not by a run
            return None
        stale = next((key for key, tag in self._stored[2].items() if tags.get(key) != tag), None)
        files = [name for name in REPORTS if (output / name).is_file()]
        return self._stored[1] | {"stale": stale, "files": files, "stamp": str(stamp)}

    def _stamp(self) -> list[tuple[Any, ...]]:
        """Return what changes when a file of the project does: names, times and sizes, the output left out."""
        inputs = [self.folder / name for name in self._known[1].get("inputs") or ()]  # some may lie elsewhere
        folders = [at for at in self.folder.iterdir() if at.is_dir() and at.name not in ("output", OWN)]
        found = set()
        for path in (*inputs, *(path for top in (self.folder, *folders) for path in top.iterdir())):
            with suppress(OSError):
                found.add((str(path), (at := path.stat()).st_mtime_ns, at.st_size))
        return sorted(found)


class Session:
    """What the server has: the project that is open, or none, and the worker; `home`: where new projects are made."""

    def __init__(self, home: Path, folder: Path | None) -> None:
        self.home, self.lock, self.worker, self.root = home, threading.RLock(), Worker(), self
        self.receiving = threading.Lock()
        self.opened: Opened | None = None
        self.staging = tempfile.TemporaryDirectory(prefix="assesto-", ignore_cleanup_errors=True)
        self.open(folder)

    def open(self, folder: Path | None) -> None:
        """Show another project, or none. Raises ProjectError where there is none in the folder."""
        staging = Path(self.staging.name)
        self.root.opened = None if folder is None else Opened(project_file(folder).parent, staging)

    def held(self, tag: str | None) -> Session:
        """Return the session with its project held fast, whatever is opened meanwhile.

        `tag`: of the project of the page, "": none, None: any. Raises ConflictError where another one is open.
        """
        found = copy.copy(self.root)
        if tag is not None and tag != (found.opened.tag if found.opened else ""):
            raise ConflictError("another project was opened meanwhile; nothing was done")
        return found

    @property
    def project(self) -> Opened:
        """The project. Raises ProjectError where none is open."""
        if self.opened is None:
            raise ProjectError("no project is open; open a folder, or make a new project")
        return self.opened

    @property
    def folder(self) -> Path:
        """The folder of the project. Raises ProjectError where none is open."""
        return self.project.folder

    def state(self) -> dict[str, Any]:
        """Return what the page shows beside the drawing; without a project those that are there."""
        if self.opened is None:
            found = sorted(path.parent.name for name in SOURCES for path in self.home.glob(f"*/{name}"))
            return {"folder": None, "home": str(self.home), "projects": found}
        with self.lock:
            return self.opened.state()

    def receive(self, name: str, kind: str, content: bytes, time_step: float | None = None) -> dict[str, Any]:
        """Keep a dropped file in the project, once it can be read as what it should be; return its picture and name.

        `time_step` (s): of a record of one column. A file that is there stays: another one of its name gets a number.
        Without a project a drawing is kept for a new one. Raises ProjectError for a name that is none, a suffix that
        does not fit, or a file that cannot be read.
        """
        if kind not in PLACES:
            raise ProjectError(f"kind: must be one of {', '.join(PLACES)}")
        suffixes, place = PLACES[kind]
        if Path(file_name(name)).suffix.lower() not in suffixes:
            ends = " or ".join(suffixes)
            raise ProjectError(f"{name}: must end in {ends}; drop another file, or export it as one")
        with self.receiving:  # two pages may drop files of one name
            if self.opened is None:
                write_atomically(self.dropped(name), content)
                return self.look(kind, self.dropped(name)) | {"name": name}
            path, number = self.folder / place / name, 1
            while path.exists() and path.read_bytes() != content:
                number += 1
                path = path.with_name(f"{Path(name).stem}-{number}{Path(name).suffix}")
            trial = self.folder / OWN / "dropped" / path.name
            try:
                write_atomically(trial, content)
                picture = self.look(kind, trial, **({"time_step": time_step} if time_step else {}))
                path.parent.mkdir(exist_ok=True)
                trial.replace(path)
            finally:
                trial.unlink(missing_ok=True)
            return picture | {"name": path.relative_to(self.folder).as_posix()}

    def dropped(self, name: str) -> Path:
        """Return the place of a drawing that is dropped without a project. Raises ProjectError as `file_name`."""
        return Path(self.staging.name) / file_name(name)

    def look(self, kind: str, path: Path, **more: Any) -> dict[str, Any]:
        """Return the picture of a file of some kind. Raises ProjectError where it cannot be read as one."""
        try:
            return dict(self.worker.ask(kind, path=path, **more))
        except ProjectError as error:
            raise ProjectError(str(error).replace(f"{path.parent}{os.sep}", "")) from None

    def close(self) -> None:
        """End what belongs to the server; a run goes on."""
        self.worker.end()
        self.staging.cleanup()


def file_name(name: str) -> str:
    """Return a name of a file or folder, in no folder and not hidden. Raises ProjectError for any other text."""
    plain_name = name.isprintable() and Path(name).name == name and "\\" not in name and len(name) <= 120
    if not plain_name or not name or name.startswith("."):
        raise ProjectError(f"{name[:120]!r}: no name of a file or folder; write another")
    return name
