"""The server as those see it who have no business with it: other hosts, other pages, other files, too many bytes."""

import http.client
import json
import os
import signal
import socket
import stat
import subprocess
import sys
import threading
import urllib.request

import pytest
import uvicorn

from assessment.app import server
from assessment.app.server import _running, application
from assessment.app.session import Session
from assessment.cli.main import main
from tests.support.block_project import write_block

TOKEN = "t" * 32


class Client:
    """One who speaks HTTP with a server, with the cookie of its page unless told otherwise."""

    def __init__(self, port):
        self.port, self.cookie = port, None

    def ask(self, method, path, body=None, host=None, cookie=True, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.port)
        connection.putrequest(method, path, skip_host=True)
        headers = {key.replace("_", "-"): value for key, value in headers.items()}
        if host != "":
            headers = {"Host": host or f"127.0.0.1:{self.port}"} | headers
        if cookie and self.cookie:
            headers["Cookie"] = self.cookie
        if body is not None and "Transfer-Encoding" not in headers:
            headers = {"Content-Length": str(len(body))} | headers
        for key, value in headers.items():
            connection.putheader(key, value)
        connection.endheaders(body)
        answer = connection.getresponse()
        answer.text = answer.read().decode(errors="replace")
        connection.close()
        return answer

    def post(self, name, sent=None, **headers):
        body = json.dumps(sent or {}).encode()
        return self.ask("POST", f"/{name}", body, **{"Content_Type": "application/json"} | headers)

    def enter(self, token=TOKEN, **headers):
        return self.ask("GET", f"/?token={token}", cookie=False, **headers)


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    folder = write_block(tmp_path_factory.mktemp("served") / "block")
    (folder / "output").mkdir()
    (folder / "output" / "report.html").write_text("<script>1</script>", encoding="utf-8")
    (folder / "secret.key").write_text("secret", encoding="utf-8")
    (folder.parent / "outside.svg").write_text("outside", encoding="utf-8")
    (folder / "output" / "link.svg").symlink_to(folder.parent / "outside.svg")
    session = Session(folder.parent, folder)
    listening = socket.create_server(("127.0.0.1", 0))
    port = listening.getsockname()[1]
    running = uvicorn.Server(
        uvicorn.Config(application(session, port, TOKEN), log_level="critical", lifespan="off")
    )
    thread = threading.Thread(target=running.run, args=([listening],))
    thread.start()
    client = Client(port)
    client.session, client.folder = session, folder
    client.cookie = client.enter().getheader("Set-Cookie").partition(";")[0]
    yield client
    running.should_exit = True
    thread.join()
    session.close()


def test_the_token_opens_the_page_and_leaves_a_cookie_for_it_alone(served):
    answer = served.enter()
    assert answer.status == 200
    cookie = answer.getheader("Set-Cookie")
    assert cookie.startswith(f"assesto_{served.port}=")
    assert TOKEN not in cookie
    assert {"HttpOnly", "SameSite=strict"} <= {part.strip() for part in cookie.split(";")}
    assert served.ask("GET", "/").status == 200


@pytest.mark.parametrize("token", ["", TOKEN[:-1], TOKEN + "t"])
def test_another_token_opens_nothing(served, token):
    answer = served.enter(token)
    assert answer.status == 403
    assert answer.getheader("Set-Cookie") is None
    assert "<" not in answer.text


@pytest.mark.parametrize("cookie", ["", f"assesto={TOKEN}"])
def test_without_the_cookie_nothing_is_answered(served, cookie):
    for ask in (
        lambda: served.post("state", cookie=False, Cookie=cookie),
        lambda: served.post(f"state?token={TOKEN}", cookie=False, Cookie=cookie),
        lambda: served.ask("GET", "/output/report.html", cookie=False, Cookie=cookie),
        lambda: served.ask("PUT", "/file/a.dxf?kind=drawing", b"0", cookie=False, Cookie=cookie),
    ):
        assert ask().status == 403
    assert served.post("state").status == 200


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1", "127.0.0.1:1", "localhost.evil.example:{port}", ""]
)
def test_another_host_is_refused_token_or_not(served, host):
    """A name of somebody else that resolves to this machine (DNS rebinding)."""
    assert served.enter(host=host.format(port=served.port)).status in (400, 403)
    try:
        assert served.post("state", host=host.format(port=served.port)).status in (400, 403)
    except ConnectionResetError:  # no host is no HTTP: the server may hang up before it has read the body
        assert not host


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"}, {"Origin": "null"}, {"Origin": "http://127.0.0.1:1"},
        {"Origin": "https://127.0.0.1:{port}"}, {"Sec_Fetch_Site": "cross-site"},
        {"Sec_Fetch_Site": "same-site"},
    ],
)  # fmt: skip
def test_another_page_is_refused_even_with_token_and_cookie(served, headers):
    headers = {key: value.format(port=served.port) for key, value in headers.items()}
    assert served.enter(**headers).status == 403
    assert served.post("state", **headers).status == 403
    assert served.ask("PUT", "/file/a.dxf?kind=drawing", b"0", **headers).status == 403


def test_its_own_page_is_not(served):
    assert (
        served.post("state", Origin=f"http://127.0.0.1:{served.port}", Sec_Fetch_Site="same-origin").status
        == 200
    )


@pytest.mark.parametrize("kind", ["text/plain", ""])
def test_a_form_is_no_question(served, kind):
    assert served.ask("POST", "/run", b"{}", Content_Type=kind).status == 415


@pytest.mark.parametrize("body", [b"{", b"[]", b"[" * 100_000, b'{"a": NaN}', b"\xff"])
def test_what_is_no_object_of_json_is_refused(served, body):
    assert served.ask("POST", "/edit", body, Content_Type="application/json").status == 422


@pytest.mark.parametrize(
    "path",
    [
        "/output/../project.toml", "/output/..%2fproject.toml", "/output/%2e%2e/%2e%2e/outside.svg",
        "/output//etc/passwd", "/output/link.svg", "/output/.assesto.lock", "/output/", "/files/secret.key",
        "/files/project.toml", "/files/../outside.svg", "/files/.assesto/at", "/files/output%00.svg",
        "/static/../page.html", "/static/page.html", "/static/..%2f..%2fapp_it.toml", "/etc/passwd",
    ],
)  # fmt: skip
def test_no_path_leads_out(served, path):
    answer = served.ask("GET", path)
    assert answer.status == 404
    assert answer.text in ("no such file", "Not Found")


def test_the_report_has_an_origin_of_its_own(served):
    answer = served.ask("GET", "/output/report.html")
    policies = answer.headers.get_all("Content-Security-Policy")
    assert len(policies) == 1
    assert policies[0].startswith("sandbox allow-scripts; default-src 'none'")
    assert "allow-same-origin" not in policies[0]


def test_the_page_runs_no_script_but_its_own(served):
    (policy,) = served.enter().headers.get_all("Content-Security-Policy")
    assert policy.startswith("default-src 'none'; script-src 'self'")
    assert "unsafe" not in policy
    page = server.template("app/page.html")
    assert page.count("<script") == 1
    assert " on" not in "".join(part.partition(">")[0] for part in page.split("<")[1:]).replace(" one", "")
    for name in server.STATIC:
        script = server.template(f"app/{name}")
        assert "innerHTML" not in script
        assert served.ask("GET", f"/static/{name}").status == 200


@pytest.mark.parametrize("path", ["/", "/static/app.js", "/output/report.html", "/nothing"])
def test_every_answer_is_for_the_page_alone(served, path):
    answer = served.ask("GET", path)
    assert answer.getheader("X-Content-Type-Options") == "nosniff"
    assert answer.getheader("Cross-Origin-Resource-Policy") == "same-origin"
    assert answer.getheader("Cache-Control") == "no-store"
    assert answer.getheader("Access-Control-Allow-Origin") is None


def test_too_much_is_not_read(served, monkeypatch):
    monkeypatch.setattr(server, "MOST_DROPPED", 1000)
    monkeypatch.setattr(server, "MOST_SENT", 1000)
    announced = served.ask("PUT", "/file/a.dxf?kind=drawing", b"0" * 1001)
    assert (announced.status, "50 MB" in announced.text or "MB" in announced.text) == (413, True)
    assert served.post("edit", {"changes": ["x" * 1000]}).status == 413
    pieces = b"3e9\r\n" + b"0" * 1001 + b"\r\n0\r\n\r\n"  # whose length is not told
    untold = served.ask("PUT", "/file/a.dxf?kind=drawing", pieces, Transfer_Encoding="chunked")
    assert untold.status == 413
    assert [path.name for path in served.folder.glob("a*.dxf")] == []


@pytest.mark.parametrize(
    "name",
    ["..%2fup.dxf", ".hidden.dxf", "a%5cb.dxf", "a%00.dxf", "run.sh", "a.html", "x" * 130 + ".dxf", "%2e%2e"],
)
def test_a_dropped_file_has_a_plain_name_of_a_known_kind(served, name):
    before = sorted(path.name for path in served.folder.rglob("*"))
    answer = served.ask("PUT", f"/file/{name}?kind=drawing", b"0")
    assert answer.status in (404, 422)
    assert sorted(path.name for path in served.folder.rglob("*")) == before


@pytest.mark.parametrize("method", ["DELETE", "OPTIONS"])
def test_no_other_method_is_answered(served, method):
    assert served.ask(method, "/state").status in (404, 405)


def test_a_page_of_another_project_gets_nothing(served):
    """A tab that shows what was open before another tab opened this."""
    known = json.loads(served.post("state").text)["project"]
    assert served.post("edit", {"digest": "x", "changes": []}, X_Project="0" * 16).status == 409
    assert served.post("live", X_Project="").status == 409
    assert served.ask("PUT", "/file/a.csv?kind=record", b"0", X_Project="0" * 16).status == 409
    assert served.ask("GET", "/output/report.html?project=0").status == 404
    assert served.ask("GET", f"/output/report.html?project={known}").status == 200
    assert served.post("judgement", X_Project=known).status == 200


def test_a_bug_is_told_with_its_number_and_its_place_is_in_the_log(served, monkeypatch):
    def broken(*_):
        raise KeyError("inside")

    monkeypatch.setitem(server.ANSWERS, "state", broken)
    answer = served.post("state")
    said = json.loads(answer.text)["error"]
    assert answer.status == 500
    assert said.startswith("internal error ")
    log = (served.folder / ".assesto" / "faults").read_text(encoding="utf-8")
    assert said.split()[2].rstrip(":") in log
    assert "in broken" in log


COMMAND = [sys.executable, "-m", "assessment.cli", "app"]


def started(*arguments):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    return subprocess.Popen(
        [*COMMAND, *map(str, arguments), "--no-browser"],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def test_it_prints_where_it_is_and_a_second_one_opens_the_first(tmp_path, capsys):
    folder = write_block(tmp_path / "block")
    first = started(folder)
    address = first.stdout.readline().strip()
    assert address.startswith("http://127.0.0.1:")
    assert len(address.partition("token=")[2]) == 32
    assert b"<!doctype html>" in urllib.request.urlopen(address).read()
    place = folder / ".assesto" / "at"
    while not place.is_file() or not place.read_text(encoding="utf-8"):
        pass
    if os.name != "nt":
        assert stat.S_IMODE(place.stat().st_mode) == 0o600
    assert main(["app", str(folder / "project.toml"), "--no-browser"]) == 0
    assert capsys.readouterr().out.strip() == address
    port = address.partition("127.0.0.1:")[2].partition("/")[0]
    other = write_block(tmp_path / "other")
    assert main(["app", str(other), "--port", port, "--no-browser"]) == 2
    assert capsys.readouterr().err.startswith(f"error: --port {port}: ")
    first.send_signal(signal.SIGINT)
    assert first.communicate()[1].splitlines() == ["Ctrl-C ends it; a run that it has started goes on"]
    assert first.returncode == 0
    assert not place.exists()


@pytest.mark.parametrize("path", ["shutdown", "?token=x", "?token=" + "x" * 32 + "&all=1"])
def test_no_other_server_of_this_machine_is_asked(tmp_path, path):
    """A folder of somebody else's may name one."""
    with socket.create_server(("127.0.0.1", 0)) as other:
        other.settimeout(0.0)
        port = other.getsockname()[1]
        (tmp_path / "at").write_text(f"http://127.0.0.1:{port}/{path}", encoding="utf-8")
        assert _running(tmp_path / "at") is None
        with pytest.raises(BlockingIOError):
            other.accept()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere"], "no such folder"),
        (["--port", "70000"], "no port"),
        (["--port", "x"], "no port"),
        (["."], "holds no project.toml"),
    ],
)
def test_what_cannot_be_shown_is_told(tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    try:
        code = main(["app", *arguments, "--no-browser"])
    except SystemExit as ended:
        code = ended.code
    assert code == 2
    assert said in capsys.readouterr().err
