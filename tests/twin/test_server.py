"""The line: who gets in, who gets what, and who is left."""

import json
import socket
import time

import pytest

from drillrig_env.deploy.line import LONGEST
from drillrig_env.twin import server
from tests.twin.serving import serving

HELLO = {"hello": "test", "version": 1}


class Client:
    """A client that says what it likes."""

    def __init__(self, served, *first):
        host, port = served.address.split(":")
        self.socket = socket.create_connection((host, int(port)), timeout=10.0)
        self.file = self.socket.makefile("rb")
        for message in first:
            self.say(message)

    def say(self, message):
        self.socket.sendall(message if isinstance(message, bytes) else json.dumps(message).encode() + b"\n")

    def hear(self):
        line = self.file.readline()
        return json.loads(line) if line else None

    def answer(self, name):
        while (message := self.hear()) is not None and name not in message:
            pass
        return message


@pytest.fixture
def served():
    with serving() as served:
        yield served


def test_a_client_is_greeted_and_told_what_the_rig_measures(served):
    client = Client(served, HELLO)
    greeting = client.hear()
    assert greeting["channels"] == {"top_speed": "rad/s", "current": "A", "voltage": "V", "string_torque": "N m"}
    assert (greeting["period"], greeting["state"], greeting["waits"]) == (0.1, "idle", True)
    client.say({"until": 0.35, "first": False})
    times = [client.hear()["time"] for _ in range(3)]
    assert times == pytest.approx([0.1, 0.2, 0.3])
    assert client.hear() == {"now": pytest.approx(0.36)}
    client.say({"until": 9.0, "first": True})
    assert client.hear()["time"] == pytest.approx(0.4)
    assert client.hear() == {"now": pytest.approx(0.4)}


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ([b"GET / HTTP/1.1\r\n"], "is no JSON"),
        ([b"\x00\xff\xfe\n"], "is no JSON"),
        ([b"[" * 9000 + b"\n"], "is no JSON"),
        ([b"[1, 2]\n"], "allowed: a JSON object"),
        ([b"x" * (3 * LONGEST)], f"{LONGEST} bytes a line"),
        ([{"arm": True}], "no hello of version 1"),
        ([{**HELLO, "version": 2}], "no hello of version 1"),
        ([{**HELLO, "token": "wrong"}], "the token is not this rig's"),
        ([b'{"hello": "me", "version": 1, "token": "\\ud800"}\n'], "the token is not this rig's"),
        ([{**HELLO, "token": 5}], "the token is not this rig's"),
        ([HELLO, {"stop": 1}], "stop is not known; allowed: arm, command, release, until"),
        ([HELLO, {}], "nothing is not known"),
        ([HELLO, {"command": 2.0}], "command without the rig"),
        ([HELLO, {"arm": False}], "arm = False is not allowed; allowed: true"),
        ([HELLO, {"release": 1}], "release = 1 is not allowed; allowed: true"),
        ([HELLO, {"until": "tomorrow"}], "until = 'tomorrow' is not allowed"),
        ([HELLO, b'{"until": 1' + b"0" * 400 + b"}\n"], "until = 1000"),
        ([HELLO, {"until": 1e9}], "until = 1000000000.0 s is not allowed"),
        ([HELLO, b'{"until": NaN}\n'], "until = nan is not allowed"),
    ],
)
def test_what_is_no_line_of_the_protocol_is_refused_and_ends_the_connection(served, said, told):
    client = Client(served, *said)
    assert told in client.answer("refused")["refused"]
    assert client.hear() is None
    assert Client(served, HELLO).hear()["rig"]  # the next one is served


def test_with_a_token_nobody_gets_in_without_it():
    with serving(token="a" * 20) as served:
        assert "token" in Client(served, HELLO).hear()["refused"]
        assert "token" in Client(served, {**HELLO, "token": "a" * 19 + "é"}).hear()["refused"]
        assert Client(served, {**HELLO, "token": "a" * 20}).hear()["rig"]


def test_half_a_line_waits_for_the_rest(served):
    client = Client(served, b'{"hello": "me", ')
    client.say(b'"version": 1}\n{"arm": true}\n')
    assert client.hear()["rig"]
    assert client.hear()["armed"] == served.station.rig.reference


def test_one_of_two_clients_has_the_rig_and_both_see_it(served):
    one, other = Client(served, HELLO, {"arm": True}), Client(served, HELLO)
    assert other.hear()["rig"]
    assert one.answer("armed")
    other.say({"arm": True})
    assert "another client has the rig" in other.answer("refused")["refused"]
    watcher = Client(served, HELLO)
    assert watcher.hear()["state"] == "armed"
    one.say({"command": 2.5})
    one.say({"until": 0.1, "first": False})
    assert watcher.hear()["reference"] == 2.5
    one.say({"release": True})
    one.say({"until": 0.2, "first": False})
    assert watcher.hear()["state"] == "idle"


def test_a_client_that_goes_leaves_the_rig_to_the_watchdog():
    with serving(waits=False, speed=20.0) as served:
        one = Client(served, HELLO, {"arm": True})
        assert one.answer("armed")
        one.file.close()
        one.socket.close()
        watcher = Client(served, HELLO)
        assert watcher.hear()["state"] == "armed"
        while watcher.hear()["state"] != "tripped":
            pass
        watcher.say({"arm": True})
        assert watcher.answer("armed")
        assert "no command for" in served.station.events.of("watchdog")[0].reason


def test_time_does_not_wait_where_it_is_not_asked_to():
    with serving(waits=False, speed=20.0) as served:
        client = Client(served, HELLO, {"until": 5.0})
        assert "the time of this rig does not wait" in client.answer("refused")["refused"]


def test_of_two_that_ask_for_time_each_gets_it(served):
    one, other = Client(served, HELLO, {"until": 1.0, "first": False}), Client(served, HELLO, {"until": 0.5})
    times = sorted([one.answer("now")["now"], other.answer("now")["now"]])
    assert times[-1] == pytest.approx(1.0)


def test_a_client_that_does_not_read_is_left_and_holds_nobody_up():
    with serving(waits=False, speed=500.0) as served:
        lazy = Client(served, HELLO)
        lazy.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        watcher = Client(served, HELLO)
        watcher.hear()
        end = time.monotonic() + 30.0
        clients = served.pace.receivers[0].__self__._clients
        while len(clients) > 1 and time.monotonic() < end:
            assert watcher.hear()
        assert len(clients) == 1


def test_a_client_that_says_nothing_is_left(served, monkeypatch):
    monkeypatch.setattr(server, "_HELLO_TIME", 0.2)
    silent = Client(served)
    assert "no line within 0.2 s" in silent.hear()["refused"]
    assert silent.hear() is None


def test_more_clients_than_a_rig_serves_are_refused(served):
    clients = [Client(served, HELLO) for _ in range(16)]
    assert all(client.hear()["rig"] for client in clients)
    assert "16 clients already" in Client(served, HELLO).hear()["refused"]
