"""What the page may ask: a table of pure functions of the session and of what the page has sent."""

import tomllib
from collections.abc import Callable, Mapping
from functools import cache, partial
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

from assessment.app.editing import Versions
from assessment.app.session import Session, file_name
from assessment.project.project import TOML, XLSX, json_schema, survey_project
from assessment.project.project import convert as to_other_format
from assessment.runtime.errors import ProjectError
from assessment.runtime.files import write_atomically
from assessment.workflow import STAGES

Sent = Mapping[str, Any]
Kind = TypeVar("Kind")


def schema(session: Session, _: Sent) -> dict[str, Any]:
    """Return what does not change: the schema of the project file, the words of the page, stages."""
    return {
        "schema": json_schema(),
        "words": {language: page_words(language) for language in ("it", "en")},
        "stages": STAGES,
    }


@cache
def page_words(language: str) -> dict[str, Any]:
    """Return the words of the page in a language; `keys`: name, as in the report, and meaning (in English empty)."""
    from assessment.report.language import Words, key_name, plain_text  # late: the page comes first

    found = tomllib.loads((files("templates") / f"app_{language}.toml").read_text(encoding="utf-8"))
    words = Words.of(language)
    keys = {key: [plain_text(key_name(key, words)), ""] for key in words.strings["input"]}
    for place, told in found.get("keys", {}).items():
        key, (name, meaning) = place.rpartition(".")[2], told if isinstance(told, list) else ("", told)
        keys[place] = [plain_text(key_name(key, words, name)), meaning]
    return found | {"keys": keys}


def edit(session: Session, sent: Sent) -> dict[str, Any]:
    """Make changes, [path, value] each, in the file of a digest; return its new one. Raises as Versions.write."""
    changes = _given(sent, "changes", list)
    for each in changes:
        path = each[0] if isinstance(each, list) and len(each) == 2 else None
        if not isinstance(path, list) or not all(type(part) in (str, int) for part in path):
            raise ProjectError("changes: must be [path, value] each")
    pairs = [(tuple(path), value) for path, value in changes]
    with session.lock:
        return {"digest": _history(session).write(pairs, _given(sent, "digest", str))}


def step(by: int, session: Session, sent: Sent) -> dict[str, Any]:
    """Bring the version before (-1) or after (1) back."""
    with session.lock:
        return {"digest": _history(session).step(by, sent.get("digest"))}


def live(session: Session, sent: Sent) -> dict[str, Any]:
    """Follow a support that is dragged: see worker.Live. Raises ProjectError for a target that is none."""
    target = _given(sent, "target", list)
    if len(target) != 3 or not all(isinstance(each, int | float) and abs(each) < 1e6 for each in target):
        raise ProjectError("target: must be x, z (m) and rotation (rad)")
    named = {key: _given(sent, key, str) for key in ("tag", "support")}
    how = {key: bool(sent.get(key)) for key in ("home", "whole")}
    return dict(session.worker.ask("live", folder=session.folder, target=target, **named, **how))


def record(session: Session, sent: Sent) -> dict[str, Any]:
    """Return a(t) and Sa(T) of a record of the project."""
    path, step = inside(session.folder, _given(sent, "name", str)), sent.get("time_step")
    return session.look("record", path, time_step=step if isinstance(step, float | int) else None)


def run(session: Session, sent: Sent) -> None:
    """Start a run of all stages, or `only` of some. Raises ProjectError for a stage that is none."""
    only = sent.get("only")
    if only is not None and not (isinstance(only, list) and only and set(only) <= set(STAGES)):
        raise ProjectError(f"only: must be some of {', '.join(STAGES)}")
    options = ["--fresh"] if sent.get("fresh") else []
    session.project.runs.start("run", *options, *(["--only", ",".join(only)] if only else []))


def judgement(session: Session, sent: Sent) -> dict[str, Any]:
    """Return the engineer's judgement; a `text` is written first. Raises ProjectError for one that is too long."""
    path = session.folder / "output" / "judgement.md"
    if (text := sent.get("text")) is not None:
        if not isinstance(text, str) or len(text) > 500_000:
            raise ProjectError("text: must be a text of 500000 letters at most")
        with session.lock:
            write_atomically(path, text.encode())
    return {"text": session.worker.ask("judgement", path=path) if path.is_file() else ""}


def convert(session: Session, _: Sent) -> dict[str, Any]:
    """Turn project.xlsx, which the page only reads, into project.toml. Raises ProjectError where there is none."""
    project = survey_project(session.folder)[0]
    if project.source != XLSX:
        raise ProjectError(f"{project.source}: is what the page writes; nothing to convert")
    kept = to_other_format(project.path(project.source), project.content(defaults=False))[1]
    return {"kept": kept.name}


def new(session: Session, sent: Sent) -> None:
    """Make a project in a new folder and show it: from a `template`, an `example`, or a dropped `drawing`.

    Of a drawing title, unit, depth (m) and unit weight (kN/m³) are asked, no more. Raises ProjectError for a name that
    is taken or none.
    """
    name = file_name(_given(sent, "name", str))
    folder = session.home / name
    if "template" in sent:
        session.worker.ask("template", folder=folder, template=_given(sent, "template", str))
    elif "example" in sent:
        session.worker.ask("example", folder=folder, name=_given(sent, "example", str))
    else:
        drawing = session.dropped(_given(sent, "drawing", str))
        keys = {key: sent.get(key) for key in ("title", "unit", "depth_m", "unit_weight_kN_m3", "language")}
        session.worker.ask("begin", folder=folder, drawing=drawing, given=keys)
    session.open(folder)


ANSWERS: Mapping[str, Callable[[Session, Sent], dict[str, Any] | None]] = {
    "state": lambda session, _: session.state(),
    "schema": schema,
    "model": lambda session, _: session.worker.ask("model", folder=session.folder),
    "edit": edit,
    "undo": partial(step, -1),
    "redo": partial(step, 1),
    "live": live,
    "repair": lambda session, sent: session.worker.ask(
        "repair", folder=session.folder, apply=bool(sent.get("apply"))
    ),
    "record": record,
    "spectrum": lambda session, _: session.worker.ask("spectrum", folder=session.folder),
    "run": run,
    "stop": lambda session, _: session.project.runs.stop(),
    "report": lambda session, _: session.project.runs.start("report"),
    "judgement": judgement,
    "convert": convert,
    "open": lambda session, sent: session.open(  # with `folder` null none
        None if sent.get("folder") is None else session.home / _given(sent, "folder", str)
    ),
    "new": new,
    "examples": lambda session, _: {"examples": session.worker.ask("examples")},
}


def inside(folder: Path, name: str) -> Path:
    """Return a file within a folder. Raises ProjectError for one that is not within, is hidden, or not there."""
    try:
        path = (folder / name).resolve()
        hidden = any(part.startswith(".") for part in path.relative_to(folder.resolve()).parts)
    except (ValueError, OSError):
        raise ProjectError(f"{name[:200]!r}: is not in the folder of the project") from None
    if hidden or not path.is_file():
        raise ProjectError(f"{name[:200]!r}: no such file in the folder of the project")
    return path


def _given(sent: Sent, key: str, kind: type[Kind]) -> Kind:
    value = sent.get(key)
    if not isinstance(value, kind):
        raise ProjectError(f"{key}: missing, or no {kind.__name__}")
    return value


def _history(session: Session) -> Versions:
    if (session.folder / XLSX).is_file() and not (session.folder / TOML).is_file():
        raise ProjectError(f"{session.folder}: only {TOML} is written; convert the spreadsheet first")
    return session.project.history
