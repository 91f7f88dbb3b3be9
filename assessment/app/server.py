"""`assesto app`: the server of the page, and what it may ask; answers follow from the session and what is sent.

Only this machine, only who has the token, only from the page's own address.
"""

import json
import re
import secrets
import signal
import socket
import threading
import traceback
import webbrowser
from collections.abc import Callable, Mapping
from contextlib import closing, suppress
from functools import cache, partial
from hmac import compare_digest
from http import HTTPStatus
from http.client import HTTPConnection
from http.client import HTTPException as NoHttpError
from pathlib import Path
from typing import Any, TypeVar

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Receive, Scope, Send

from assessment.app.session import OWN, ConflictError, Session, Versions, file_name
from assessment.app.worker import WorkerError
from assessment.project.project import TOML, XLSX, json_schema, survey_project
from assessment.project.project import convert as to_other_format
from assessment.runtime.console import say, tell
from assessment.runtime.errors import ProjectError, error_text, is_input_error
from assessment.runtime.files import template, template_table, write_atomically
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

    found = template_table(f"app_{language}.toml")
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
    """Make a project from a `template`, an `example`, or a dropped `drawing` in a new folder, and show it.

    Raises ProjectError for a name that is taken or none.
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


SCRIPTS = ("app.js", "drawing.js", "form.js", "panels.js", "charts.js")
STATIC = {"app.css": "text/css", **dict.fromkeys(SCRIPTS, "text/javascript")}
# files of a project and of its output that a page may show
SHOWN = {".html", ".pdf", ".docx", ".md", ".svg", ".png", ".jpg", ".jpeg", ".gif", ".csv", ".json", ".dxf"}
MOST_SENT, MOST_DROPPED = 2_000_000, 50_000_000  # bytes of a question, and of a file
PAGE = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "frame-src 'self'; form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)
FRAME = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; font-src data:; form-action 'none'; base-uri 'none'; frame-ancestors 'self'"
)
HEADERS = [
    (b"x-content-type-options", b"nosniff"), (b"referrer-policy", b"no-referrer"), (b"cache-control", b"no-store"),
    (b"cross-origin-resource-policy", b"same-origin"), (b"cross-origin-opener-policy", b"same-origin"),
]  # fmt: skip


def application(session: Session, port: int, token: str) -> ASGIApp:
    """Return the application that serves a session on a port; `token`: what opens the page."""
    cookie, key = f"assesto_{port}", secrets.token_urlsafe(24)

    def page(request: Request) -> Response:
        given = request.query_params.get("token", "")
        if not (compare_digest(given.encode(), token.encode()) or _has(request, cookie, key)):
            return _refused("open the address that assesto app has printed", 403)
        headers = {"Content-Security-Policy": PAGE}
        made = Response(template("app/page.html"), media_type="text/html", headers=headers)
        made.set_cookie(cookie, key, httponly=True, samesite="strict", path="/")
        return made

    def static(request: Request) -> Response:
        kind = STATIC.get(name := request.path_params["name"])
        return Response(template(f"app/{name}"), media_type=kind) if kind else _refused("no such file", 404)

    async def drop(request: Request) -> Response:
        name, kind = request.path_params["name"], request.query_params.get("kind", "")
        content = await _body(request, MOST_DROPPED)
        try:
            step = float(request.query_params.get("time_step", 0.0)) if kind == "record" else None
        except ValueError:
            return _refused("time_step: must be a number, in s", 400)
        return await run_in_threadpool(
            _answered, session, request, lambda to: to.receive(name, kind, content, step)
        )

    async def refused(_: Request, error: Any) -> Response:
        return _refused(error.detail, error.status_code)

    routes = [
        Route("/", page, methods=["GET"]),
        Route("/static/{name}", static, methods=["GET"]),
        Route("/{place:str}/{name:path}", partial(_file, session), methods=["GET"]),
        Route("/file/{name:path}", drop, methods=["PUT"]),
        Route("/{name:str}", partial(_question, session), methods=["POST"]),
    ]
    served = Starlette(routes=routes, exception_handlers={HTTPException: refused})

    async def guarded(scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse what does not come from the page itself before anything of it is read."""

        async def headed(message: Any) -> None:
            if message["type"] == "http.response.start":
                message["headers"] += HEADERS
            await send(message)

        if scope["type"] == "http":
            refusal = _refusal(Request(scope), port, cookie, key)
            await (refusal or served)(scope, receive, headed)

    return guarded


async def _question(session: Session, request: Request) -> Response:
    """Answer one of ANSWERS, asked with a JSON object."""
    answer = ANSWERS.get(request.path_params["name"])
    if answer is None:
        return _refused("no such question", 404)
    if request.headers.get("content-type", "").partition(";")[0] != "application/json":
        return _refused("a question is JSON", 415)
    try:
        sent = json.loads(await _body(request, MOST_SENT) or b"{}", parse_constant=int)
        json.dumps(sent, ensure_ascii=False).encode()  # half a character is no text; NaN above is no number
    except (ValueError, RecursionError):
        return _refused("no JSON", 422)
    if not isinstance(sent, dict):
        return _refused("a question is a JSON object", 422)
    return await run_in_threadpool(_answered, session, request, lambda held: answer(held, sent))


def _refusal(request: Request, port: int, cookie: str, key: str) -> Response | None:
    """Return why a request is refused, None where it is not: its Host, its Origin, where it comes from, its cookie."""
    hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
    host, origin = request.headers.getlist("host"), request.headers.getlist("origin")
    if len(host) != 1 or host[0] not in hosts:  # another name that resolves to this machine
        return _refused("this server is 127.0.0.1 alone", 403)
    elsewhere = request.headers.get("sec-fetch-site", "none") not in ("none", "same-origin")
    if elsewhere or (origin and origin != [f"http://{host[0]}"]):
        return _refused("asked from another page", 403)
    open_to_all = request.url.path == "/" or request.url.path.startswith("/static/")  # "/" asks for the token
    if not open_to_all and not _has(request, cookie, key):
        return _refused("open the address that assesto app has printed", 403)
    return None


def _has(request: Request, cookie: str, key: str) -> bool:
    return compare_digest(request.cookies.get(cookie, "").encode(), key.encode())


async def _body(request: Request, most: int) -> bytes:
    """Return what is sent, as far as it is not too large."""
    content = bytearray()
    too_large = HTTPException(413, f"more than {most // 1_000_000} MB; take what is needed of it")
    if int(request.headers.get("content-length", "0")) > most:
        raise too_large
    async for part in request.stream():
        content += part
        if len(content) > most:
            raise too_large
    return bytes(content)


def _answered(session: Session, request: Request, ask: Callable[[Session], Any]) -> Response:
    """Return an answer as JSON, or what is wrong; of a bug its last line, and its number in a file of all of it."""
    try:
        return JSONResponse({"ok": True} | (ask(session.held(request.headers.get("x-project"))) or {}))
    except ConflictError as conflict:
        return _refused(str(conflict), 409)
    except Exception as error:  # a bug in one answer: the page shows it, the server goes on
        if is_input_error(error):
            return _refused(error_text(error), 422)
        detail = str(error) if isinstance(error, WorkerError) else traceback.format_exc()
    if "\n" not in detail:  # the worker was ended from outside, which is no bug
        return _refused(detail, 500)
    number = secrets.token_hex(3)
    if session.opened is not None:
        with suppress(OSError):
            (log := session.folder / OWN / "faults").parent.mkdir(exist_ok=True)
            with log.open("a", encoding="utf-8") as file:
                file.write(f"{number}\n{detail}\n")
    return _refused(f"internal error {number}: {detail.strip().splitlines()[-1]}", 500)


def _file(session: Session, request: Request) -> Response:
    """Return a file of the output or of the project, in a frame of its own origin; 404 for everything else."""
    with suppress(KeyError, ProjectError, ConflictError):
        folder = session.held(request.query_params.get("project")).folder
        places = {"output": folder / "output", "files": folder}
        path = inside(places[request.path_params["place"]], request.path_params["name"])
        if path.suffix.lower() in SHOWN:
            return FileResponse(path, headers={"Content-Security-Policy": FRAME})
    return _refused("no such file", 404)


def _refused(text: str, status: int) -> Response:
    return PlainTextResponse(text, status) if status in (403, 404) else JSONResponse({"error": text}, status)


HOST = "127.0.0.1"
IDLE = 60  # s, after which a connection without questions ends
QUIET = {"log_level": "critical", "server_header": False, "lifespan": "off"}


def serve(folder: Path | None, port: int, browser: bool) -> None:
    """Serve a project, or none, until interrupted; a second call on a folder opens the page of the first.

    The first line printed is the address with the token. Raises ProjectError for no project, or a port that is taken.
    """
    session = Session(Path.cwd(), folder)
    place = session.folder / OWN / "at" if session.opened else None
    known = _running(place) if place else None
    listening, token = None if known else listen(port), secrets.token_urlsafe(24)
    port = listening.getsockname()[1] if listening else 0
    address = known or f"http://{HOST}:{port}/?token={token}"
    say(address)
    if browser:
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    if listening is None:
        return
    tell("Ctrl-C ends it; a run that it has started goes on")
    threading.Thread(target=session.worker.begin, daemon=True).start()  # imports take longer than the page
    served = application(session, port, token)
    config = uvicorn.Config(served, timeout_keep_alive=IDLE, timeout_graceful_shutdown=1, **QUIET)  # type: ignore[arg-type]
    try:
        if place:
            with suppress(OSError):  # only the user may read it; without it there is just no second call
                place.parent.mkdir(exist_ok=True)
                place.unlink(missing_ok=True)
                place.touch(mode=0o600)
                place.write_text(address, encoding="utf-8")
        with suppress(KeyboardInterrupt):
            uvicorn.Server(config).run([listening])
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        session.close()
        with suppress(OSError):
            if place and place.read_text(encoding="utf-8") == address:  # not that of a later one
                place.unlink()


def listen(port: int) -> socket.socket:
    """Return a socket that only this machine reaches, 0: on a free port. Raises ProjectError for one that is taken."""
    try:
        found = socket.create_server((HOST, port))
    except OSError as error:
        raise ProjectError(f"--port {port}: {error.strerror}; leave it out, or give another one") from None
    found.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, True)  # else an answer waits 40 ms for a receipt
    return found


def _running(place: Path) -> str | None:
    """Return the address of a server that shows the folder already; a folder of somebody else's may name any other."""
    with suppress(OSError, ValueError, OverflowError, NoHttpError):
        address = place.read_text(encoding="utf-8").strip()
        if ours := re.fullmatch(rf"http://{re.escape(HOST)}:(\d+)(/\?token=[\w-]{{32}})", address, re.ASCII):
            with closing(HTTPConnection(HOST, int(ours[1]), timeout=2.0)) as connection:
                connection.request("GET", ours[2])
                if connection.getresponse().status == HTTPStatus.OK:
                    return address
    return None
