"""`assesto app`: starts the server, prints where the page is, and opens it in the browser."""

from __future__ import annotations

import secrets
import signal
import socket
import threading
import webbrowser
from contextlib import suppress
from pathlib import Path

import uvicorn

from assessment.app.editing import OWN
from assessment.app.server import application
from assessment.app.session import Session
from assessment.runtime.errors import ProjectError
from assessment.runtime.terminal.console import say, tell

HOST = "127.0.0.1"
IDLE = 60  # s, after which a connection without questions ends


def serve(folder: Path | None, port: int, browser: bool) -> None:
    """Serve a project, or none, until interrupted; a second call on a folder opens the page of the first.

    The first line of standard output is the address with the token. Raises ProjectError for a folder without a project
    or a port that is taken.
    """
    session = Session(Path.cwd(), folder)
    if session.folder is not None and (running := _running(session.folder)):
        say(running)
        if browser:
            webbrowser.open(running)
        return
    listening = _listening(port)
    port, token = listening.getsockname()[1], secrets.token_urlsafe(24)
    address = f"http://{HOST}:{port}/?token={token}"
    config = uvicorn.Config(
        application(session, port, token),
        log_level="critical",
        timeout_keep_alive=IDLE,
        timeout_graceful_shutdown=1,
        server_header=False,
        lifespan="off",
    )
    say(address)
    tell("Ctrl-C ends it; a run that it has started goes on")
    place = session.folder and session.folder / OWN / "at"
    if place:
        _leave(place, address)
    threading.Thread(
        target=session.worker.begin, daemon=True
    ).start()  # its imports take longer than the page
    if browser:
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    try:
        uvicorn.Server(config).run([listening])
    except KeyboardInterrupt:
        pass
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        session.close()
        if place:
            with suppress(OSError):
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


def _running(folder: Path) -> str | None:
    """Return the address of a server that shows the folder already."""
    try:
        address = (folder / OWN / "at").read_text(encoding="utf-8").strip()
        port = int(address.removeprefix(f"http://{HOST}:").partition("/")[0])
        socket.create_connection((HOST, port), 0.5).close()
    except (OSError, ValueError):
        return None
    return address
