"""The server of the page: only this machine, only who has the token, only from the page's own address."""

from __future__ import annotations

import json
import secrets
import traceback
from functools import partial
from hmac import compare_digest
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from assessment.app.answers import ANSWERS, inside
from assessment.app.editing import OWN, ConflictError
from assessment.app.worker import WorkerError
from assessment.runtime.errors import ProjectError, error_text, is_input_error

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Receive, Scope, Send

    from assessment.app.session import Session

STATIC = {
    "app.css": "text/css",
    **dict.fromkeys(("app.js", "drawing.js", "form.js", "panels.js", "charts.js"), "text/javascript"),
}
SHOWN = {  # files of a project and of its output that a page may show
    ".html": "text/html", ".pdf": "application/pdf", ".svg": "image/svg+xml", ".png": "image/png",
    ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".gif": "image/gif", ".csv": "text/csv", ".json": "application/json",
    ".docx": "application/vnd.openxmlformats-officedocument.wordprocessingml.document",
    ".md": "text/plain", ".dxf": "application/dxf",
}  # fmt: skip
MOST_SENT, MOST_DROPPED = 2_000_000, 50_000_000  # bytes of a question, and of a file
PAGE = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "frame-src 'self'; form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)
FRAME = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; font-src data:; form-action 'none'; base-uri 'none'; frame-ancestors 'self'"
)
HEADERS = {
    "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer", "Cache-Control": "no-store",
    "Cross-Origin-Resource-Policy": "same-origin", "Cross-Origin-Opener-Policy": "same-origin",
}  # fmt: skip


class TooLargeError(Exception):
    """More bytes than are taken."""


def application(session: Session, port: int, token: str) -> ASGIApp:
    """Return the application that serves a session on a port; `token`: what opens the page."""
    cookie, key = f"assesto_{port}", secrets.token_urlsafe(24)

    def page(request: Request) -> Response:
        given = request.query_params.get("token", "")
        if not (compare_digest(given.encode(), token.encode()) or _has(request, cookie, key)):
            return _refused("open the address that assesto app has printed", 403)
        policy = {"Content-Security-Policy": PAGE}
        response = Response(_template("page.html"), media_type="text/html", headers=policy)
        response.set_cookie(cookie, key, httponly=True, samesite="strict", path="/")
        return response

    def file(request: Request) -> Response:
        return _file(session, request.path_params["place"], request.path_params["name"])

    async def question(request: Request) -> Response:
        return await _question(session, request)

    async def drop(request: Request) -> Response:
        name, kind = request.path_params["name"], request.query_params.get("kind", "")
        content = await _body(request, MOST_DROPPED)
        return await run_in_threadpool(_answered, session, partial(session.receive, name, kind, content))

    routes = [
        Route("/", page, methods=["GET"]),
        Route("/static/{name}", _static, methods=["GET"]),
        Route("/{place:str}/{name:path}", file, methods=["GET"]),
        Route("/file/{name:path}", drop, methods=["PUT"]),
        Route("/{name:str}", question, methods=["POST"]),
    ]
    served = Starlette(routes=routes, exception_handlers={TooLargeError: _too_large})

    async def guarded(scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse what does not come from the page itself before anything of it is read."""

        async def headed(message: Any) -> None:
            if message["type"] == "http.response.start":
                message["headers"] += [
                    (name.lower().encode(), text.encode()) for name, text in HEADERS.items()
                ]
            await send(message)

        if scope["type"] == "http":
            refusal = _refusal(Request(scope), port, cookie, key)
            await (refusal or served)(scope, receive, headed)

    return guarded


def _static(request: Request) -> Response:
    name = request.path_params["name"]
    return (
        Response(_template(name), media_type=STATIC[name])
        if name in STATIC
        else _refused("no such file", 404)
    )


async def _question(session: Session, request: Request) -> Response:
    """Answer one of ANSWERS, asked with a JSON object."""
    answer = ANSWERS.get(request.path_params["name"])
    if answer is None:
        return _refused("no such question", 404)
    if request.headers.get("content-type", "").partition(";")[0] != "application/json":
        return _refused("a question is JSON", 415)
    try:
        sent = json.loads(await _body(request, MOST_SENT) or b"{}", parse_constant=_no_number)
    except (ValueError, RecursionError):
        return _refused("no JSON", 422)
    if not isinstance(sent, dict):
        return _refused("a question is a JSON object", 422)
    return await run_in_threadpool(_answered, session, partial(answer, session, sent))


def _refusal(request: Request, port: int, cookie: str, key: str) -> Response | None:
    """Return why a request is refused, None where it is not: its Host, its Origin, where it comes from, its cookie."""
    hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
    host, origin = request.headers.getlist("host"), request.headers.getlist("origin")
    if len(host) != 1 or host[0] not in hosts:  # another name that resolves to this machine
        return _refused("this server is 127.0.0.1 alone", 403)
    if origin and origin != [f"http://{host[0]}"]:
        return _refused("asked from another page", 403)
    if request.headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
        return _refused("asked from another page", 403)
    if (
        request.url.path != "/"
        and not request.url.path.startswith("/static/")
        and not _has(request, cookie, key)
    ):
        return _refused("open the address that assesto app has printed", 403)
    return None


def _has(request: Request, cookie: str, key: str) -> bool:
    return compare_digest(request.cookies.get(cookie, "").encode(), key.encode())


async def _body(request: Request, most: int) -> bytes:
    """Return what is sent, as far as it is not too large."""
    parts, size = [], 0
    if int(request.headers.get("content-length", "0") or 0) > most:
        raise TooLargeError(most)
    async for part in request.stream():
        size += len(part)
        if size > most:
            raise TooLargeError(most)
        parts.append(part)
    return b"".join(parts)


async def _too_large(_: Request, error: Exception) -> Response:
    return _refused(f"more than {error.args[0] // 1_000_000} MB; take what is needed of it", 413)


def _answered(session: Session, ask: Any) -> Response:
    """Return an answer as JSON, or what is wrong; a bug is told with its number in the log."""
    try:
        return JSONResponse({"ok": True} | (ask() or {}))
    except ConflictError as conflict:
        return _refused(str(conflict), 409)
    except WorkerError as fault:
        return _bug(session, str(fault), fault.detail)
    except Exception as error:
        if is_input_error(error):
            return _refused(error_text(error), 422)
        return _bug(session, f"{type(error).__name__}: {error}", traceback.format_exc())


def _bug(session: Session, text: str, detail: str) -> Response:
    number = secrets.token_hex(3)
    if session.folder is not None and detail:
        try:
            path = session.folder / OWN / "faults"
            path.parent.mkdir(exist_ok=True)
            with path.open("a", encoding="utf-8") as log:
                log.write(f"{number}\n{detail}\n")
        except OSError:
            pass
    return _refused(f"internal error {number}: {text}", 500)


def _file(session: Session, place: str, name: str) -> Response:
    """Return a file of the output or of the project, in a frame of its own origin; 404 for everything else."""
    try:
        top = {"output": session.project / "output", "files": session.project}[place]
        path = inside(top, name)
        kind = SHOWN[path.suffix.lower()]
    except (KeyError, ProjectError):
        return _refused("no such file", 404)
    return FileResponse(path, media_type=kind, headers={"Content-Security-Policy": FRAME})


def _refused(text: str, status: int) -> Response:
    if status in (403, 404):
        return PlainTextResponse(text, status)
    return JSONResponse({"ok": False, "error": text}, status)


def _template(name: str) -> bytes:
    return (files("templates") / "app" / name).read_bytes()


def _no_number(text: str) -> float:
    raise ValueError(text)
