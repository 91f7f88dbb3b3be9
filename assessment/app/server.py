"""`assesto app`: the server of the page, its address printed and opened in the browser.

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
from collections.abc import Callable
from contextlib import closing, suppress
from functools import partial
from hmac import compare_digest
from http import HTTPStatus
from http.client import HTTPConnection
from http.client import HTTPException as NoHttpError
from importlib.resources import files
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Receive, Scope, Send

from assessment.app.answers import ANSWERS, inside
from assessment.app.editing import OWN, ConflictError
from assessment.app.session import Session
from assessment.app.worker import WorkerError
from assessment.runtime.console import say, tell
from assessment.runtime.errors import ProjectError, error_text, is_input_error

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
        made = Response(
            _template("page.html"), media_type="text/html", headers={"Content-Security-Policy": PAGE}
        )
        made.set_cookie(cookie, key, httponly=True, samesite="strict", path="/")
        return made

    def static(request: Request) -> Response:
        kind = STATIC.get(name := request.path_params["name"])
        return Response(_template(name), media_type=kind) if kind else _refused("no such file", 404)

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


def _template(name: str) -> bytes:
    return (files("templates") / "app" / name).read_bytes()


HOST = "127.0.0.1"
IDLE = 60  # s, after which a connection without questions ends
QUIET = {"log_level": "critical", "server_header": False, "lifespan": "off"}


def serve(folder: Path | None, port: int, browser: bool) -> None:
    """Serve a project, or none, until interrupted; a second call on a folder opens the page of the first.

    The first line of standard output is the address with the token. Raises ProjectError for a folder without a project
    or a port that is taken.
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
