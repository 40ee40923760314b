"""The command as it is started: its words, its ends, and a real server under connections that come and go."""

import json
import socket
import subprocess
import sys
import threading
from pathlib import Path

import pytest

pytest.importorskip("uvicorn", reason="needs the extra room")

from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from benchmarks.browser import Room
from drillrig_env.command_line import Failed
from drillrig_env.room import command, page


def refused(capsys, *words):
    """What the command says on standard error, and its exit code."""
    try:
        code = command.main([*words, "--no-browser"])
    except SystemExit as end:
        code = end.code
    return code, capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--host", "0.0.0.0"], "--host 0.0.0.0 lets other machines in, and is not allowed without --token"),
        (["--host", "0.0.0.0", "--token", "short"], "length of --token = 5 characters is not allowed; allowed: >= 16"),
        (["--token", "short"], "length of --token"),
        (["--port", "70000"], "--port: '70000' is not allowed"),
        (["--story", "bistabilty"], "did you mean bistability?"),
        (["--rig", "nowhere.toml"], "nowhere.toml"),
        (["--policy", "nobody"], "policy 'nobody' is not known"),
        (["--policy", "nowhere.py:Law"], "there is no file nowhere.py"),
        (["--replay", "nowhere.json"], "there is no file nowhere.json"),
        (["--clients", "0"], "--clients: '0' is not allowed"),
        (["--lecture"], "unknown argument --lecture"),
    ],
)
def test_words_that_are_not_allowed_end_with_a_sentence(capsys, words, sentence):
    code, told = refused(capsys, *words)
    assert (code, sentence in told, "Traceback" in told) == (2, True, False), told


def test_without_its_parts_it_says_which_command_brings_them(tmp_path):
    with pytest.raises(Failed, match=r"uPlot.js, which plots the lines; in a clone of DrillRig: `make room` brings it"):
        page.page_files(tmp_path)


def test_every_file_that_the_page_asks_for_is_served(tmp_path, monkeypatch):
    monkeypatch.setattr(page, "NEEDED", ())  # the parts may not be there where nobody looks at the page
    served, web = page.page_files(), page.WEB
    asked = set()
    for file in [*web.glob("*.js"), web / "index.html"]:
        for quoted in file.read_text(encoding="utf-8").split('"')[1::2]:
            if quoted.startswith(("./", "/")) and quoted.endswith((".js", ".css", ".svg")):
                asked.add("/" + quoted.removeprefix(".").removeprefix("/"))
    assert {"/main.js", "/look.css", "/parts/uPlot.js"} <= asked
    assert {path for path in asked if not path.startswith("/parts/")} <= set(served)
    assert all(not path.endswith(".d.ts") for path in served)


@pytest.fixture(scope="module")
def served():
    if not (Path(page.PARTS) / "uPlot.js").is_file():
        pytest.skip("the page's parts are not fetched: python -m drillrig_env.room.parts")
    room = Room(("--port", "0", "--clients", "3"))
    yield room
    room.close()


@pytest.fixture
def ask(served):
    return f"{served.address.replace('http', 'ws')}/room"


def begun(socket):
    socket.recv()
    socket.send(json.dumps({"do": "begin", "version": 1, "setting": {"b": "constant"}}))
    while True:
        message = socket.recv()
        if isinstance(message, str) and json.loads(message)["is"] == "state":
            return


@pytest.mark.room
def test_a_thousand_connections_one_after_the_other_leave_nothing_behind(served, ask):
    def resident():
        status = Path(f"/proc/{served.process.pid}/status").read_text()
        return int(status.split("VmRSS:")[1].split()[0])

    def threads():
        return len(list(Path(f"/proc/{served.process.pid}/task").iterdir()))

    for number in range(1000):
        with connect(ask) as socket:
            if number % 10 == 0:
                begun(socket)
        if number == 200:
            before, at_work = resident(), threads()
    with connect(ask) as socket:
        begun(socket)
    assert resident() < before + 40_000  # kB
    assert threads() <= at_work + 8


def flood(socket, text):
    for _ in range(100_000):
        socket.send(text)


@pytest.mark.room
def test_a_client_that_floods_or_sends_what_is_too_long_is_cut_off_and_others_go_on(served, ask):
    with connect(ask) as other:
        begun(other)
        with connect(ask) as flooding:
            begun(flooding)
            with pytest.raises(ConnectionClosed):
                flood(flooding, '{"do":"alive"}')
        with connect(ask) as long:
            begun(long)
            with pytest.raises(ConnectionClosed):
                flood(long, "x" * 5_000_000)
        other.send(json.dumps({"do": "pause", "paused": True}))
        while True:
            message = other.recv()
            if isinstance(message, str) and json.loads(message).get("paused"):
                break


@pytest.mark.room
def test_a_real_server_refuses_strangers(served, ask):
    with pytest.raises(InvalidStatus):
        connect(ask, origin="http://evil.example")
    with pytest.raises(InvalidStatus):
        connect(ask, additional_headers={"Host": "evil.example"})
    host, port = served.address.removeprefix("http://").split(":")
    for path in (
        b"GET /../../etc/passwd HTTP/1.1",
        b"GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1",
        b"GET file:///etc/passwd HTTP/1.1",
    ):
        with socket.create_connection((host, int(port)), timeout=10) as raw:
            raw.sendall(f"GET {path} HTTP/1.1\r\nHost: {host}:{port}\r\nConnection: close\r\n\r\n".encode())
            answer = b"".join(iter(lambda raw=raw: raw.recv(65536), b""))
        assert b"root:" not in answer
        assert b" 200 " not in answer.splitlines()[0]
    for rubbish in (b"\x00" * 4096, b"GET", b"\x16\x03\x01\x02\x00\x01\x00"):
        with socket.create_connection((host, int(port)), timeout=10) as raw:
            raw.sendall(rubbish)
    with connect(ask) as one:
        begun(one)


@pytest.mark.room
def test_a_client_that_reads_nothing_makes_the_server_keep_nothing(served, ask):
    def resident():
        return int(Path(f"/proc/{served.process.pid}/status").read_text().split("VmRSS:")[1].split()[0])

    host, port = served.address.removeprefix("http://").split(":")
    narrow = socket.socket()
    narrow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 16_384)
    narrow.connect((host, int(port)))
    with connect(ask, sock=narrow, max_queue=1) as slow, connect(ask) as quick:
        begun(slow)
        begun(quick)
        slow.send('{"do":"speed","times":10}')
        before = resident()
        deadline = threading.Event()
        threading.Timer(10.0, deadline.set).start()
        frames = 0
        while not deadline.is_set():
            frames += isinstance(quick.recv(), bytes)
        assert resident() < before + 20_000  # kB; 10 s at ten times real time are 1.1 MB of frames
        assert frames > 50  # ten a second, were nobody else at work
        for _ in range(1000):  # what the system had kept, and then the gap
            message = slow.recv()
            if isinstance(message, bytes) and message[3] & 1:
                break
        else:
            pytest.fail("nothing was left out")


@pytest.mark.room
def test_the_port_that_is_taken_is_said_and_ctrl_c_ends_it_cleanly(served):
    port = served.address.rpartition(":")[2]
    line = [sys.executable, "-m", "drillrig_env.cli", "room", "--no-browser", "--port", port]
    told = subprocess.run(line, capture_output=True, text=True, timeout=120)
    assert told.returncode == 1
    assert f"cannot listen on 127.0.0.1, port {port}" in told.stderr
    assert "Traceback" not in told.stderr
    room = Room(("--port", "0", "--host", "0.0.0.0", "--token", "a-token-that-is-long"))
    assert "?token=a-token-that-is-long" in room.address
    assert room.close() == 0
