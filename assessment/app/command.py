"""`assesto app`: starts the server, prints where the page is, and opens it in the browser."""

from __future__ import annotations

import secrets
import signal
import socket
import threading
import webbrowser
from contextlib import closing, suppress
from http import HTTPStatus
from http.client import HTTPConnection, HTTPException
from pathlib import Path

import uvicorn

from assessment.app.editing import OWN
from assessment.app.server import application
from assessment.app.session import Session
from assessment.runtime.console import say, tell
from assessment.runtime.errors import ProjectError

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
    listening = None if known else _listening(port)
    token = secrets.token_urlsafe(24)
    address = known or f"http://{HOST}:{listening.getsockname()[1] if listening else 0}/?token={token}"
    say(address)
    if browser:
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    if listening is None:
        return
    tell("Ctrl-C ends it; a run that it has started goes on")
    threading.Thread(
        target=session.worker.begin, daemon=True
    ).start()  # its imports take longer than the page
    served = application(session, listening.getsockname()[1], token)
    config = uvicorn.Config(served, timeout_keep_alive=IDLE, timeout_graceful_shutdown=1, **QUIET)  # type: ignore[arg-type]
    try:
        if place:
            _leave(place, address)
        with suppress(KeyboardInterrupt):
            uvicorn.Server(config).run([listening])
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        session.close()
        if place:
            with suppress(OSError):
                if place.read_text(encoding="utf-8") == address:  # not that of a later one
                    place.unlink()


def _listening(port: int) -> socket.socket:
    try:
        return socket.create_server((HOST, port))
    except OSError as error:
        raise ProjectError(f"--port {port}: {error.strerror}; leave it out, or give another one") from None


def _leave(place: Path, address: str) -> None:
    """Leave the address where only the user may read it, for a second call; without it there is just none."""
    with suppress(OSError):
        place.parent.mkdir(exist_ok=True)
        place.unlink(missing_ok=True)
        place.touch(mode=0o600)
        place.write_text(address, encoding="utf-8")


def _running(place: Path) -> str | None:
    """Return the address of a server that shows the folder already: one that lets its token in."""
    with suppress(OSError, ValueError, HTTPException):
        address = place.read_text(encoding="utf-8").strip()
        port, _, path = address.removeprefix(f"http://{HOST}:").partition("/")
        with closing(HTTPConnection(HOST, int(port), timeout=2.0)) as connection:
            connection.request("GET", f"/{path}")
            if connection.getresponse().status == HTTPStatus.OK:
                return address
    return None
