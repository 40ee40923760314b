"""The server as a client meets it: who is let in, what is answered, what is refused, and what it never does."""

import json
import struct
import time

import numpy as np
import pytest

pytest.importorskip("starlette", reason="needs the extra room")

from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from drillrig_env.course import COLUMNS
from drillrig_env.env.recorded import Recorded
from drillrig_env.env.single import DrillRigEnv
from drillrig_env.rig import Rig
from drillrig_env.room import app
from drillrig_env.room.app import room_app
from drillrig_env.room.client import REFUSED, TOO_BIG, TOO_MANY, Beginning
from drillrig_env.room.door import COOKIE, Door
from drillrig_env.room.frames import HEADER_BYTES, frame_bytes
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.limits import Limits
from drillrig_env.room.setting import Setting
from drillrig_env.room.stock import Stock
from drillrig_env.room.stories import STORIES

HERE = "http://127.0.0.1:8347"
ROOM = f"ws://127.0.0.1:8347{app.ROOM}"
OUTSIDE = f"ws://rig.example:8347{app.ROOM}"
TOKEN = "a-token-that-is-long"


@pytest.fixture
def client(stock, files):
    """A client of a room that waits for no one long."""

    def client(door=None, limits=None, base=HERE, **beginning):
        room = room_app(stock, files, Beginning(Setting(b="constant"), **beginning), door or Door("127.0.0.1"), limits)
        return TestClient(room, base_url=base)

    return client


class Page:
    """What a page does at its websocket."""

    def __init__(self, socket, setting=None, version=1):
        self.socket = socket
        self.welcome = self.text("welcome")
        self.say("begin", version=version, setting=setting or {})

    def say(self, do, **entries):
        self.socket.send_text(json.dumps({"do": do, **entries}))

    def next(self):
        message = self.socket.receive()
        if message["type"] == "websocket.close":
            raise WebSocketDisconnect(message["code"], message.get("reason"))
        return message["text"] if message.get("text") is not None else message["bytes"]

    def text(self, kind, **wanted):
        """The next text of a kind whose entries are as wanted."""
        while True:
            message = self.next()
            if isinstance(message, str):
                found = json.loads(message)
                if found["is"] == kind and all(found[name] == value for name, value in wanted.items()):
                    return found

    def frame(self):
        while True:
            message = self.next()
            if isinstance(message, bytes):
                return message


def test_the_page_is_served_with_headers_that_let_nothing_else_in(client):
    answer = client().get("/")
    assert answer.status_code == 200
    assert answer.text.startswith("<!doctype html>")
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert client().get("/main.js").headers["content-type"].startswith("text/javascript")


def test_no_path_leads_to_a_file_of_the_machine(client):
    room = client()
    for path in (
        "/../pyproject.toml", "/..%2f..%2fetc%2fpasswd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/etc/passwd",
        "/main.js/../../setting.py", "/parts/../command.py", "/index.html%00.js", "/.git/config", "/room",
    ):  # fmt: skip
        answer = room.get(path)
        assert answer.status_code == 404, path
        assert "root:" not in answer.text


def test_nothing_can_be_written(client):
    for method in ("post", "put", "delete", "patch"):
        assert getattr(client(), method)("/").status_code == 405


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example", "evil.example:8347", "", "[", "192.168.1.2"]
)
def test_another_host_is_refused(client, host):
    assert client().get("/", headers={"host": host}).status_code == 403
    with pytest.raises(WebSocketDisconnect), client().websocket_connect(ROOM, headers={"host": host}):
        pass


@pytest.mark.parametrize("host", ["localhost:8347", "127.0.0.1:1", "[::1]:8347", "LOCALHOST"])
def test_this_machine_is_let_in_by_any_of_its_names(client, host):
    assert client().get("/", headers={"host": host}).status_code == 200


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "http://127.0.0.1:9999",
        "https://127.0.0.1:8347.evil.example",
        "null",
        "file://",
        "http://[",
    ],
)
def test_a_page_from_elsewhere_is_refused(client, origin):
    with pytest.raises(WebSocketDisconnect) as refused, client().websocket_connect(ROOM, headers={"origin": origin}):
        pass
    assert refused.value.code == REFUSED


def test_the_own_page_is_let_in(client):
    with client().websocket_connect(ROOM, headers={"origin": HERE, "host": "127.0.0.1:8347"}) as socket:
        assert Page(socket).welcome["version"] == 1


def test_another_address_wants_a_token():
    for host in ("0.0.0.0", "192.168.1.2", "::", "example.org"):
        with pytest.raises(ValueError, match="not allowed without --token"):
            Door(host)
        assert Door(host, TOKEN).token == TOKEN
    for host in ("127.0.0.1", "127.0.0.5", "::1", "localhost"):
        assert Door(host).token is None
    with pytest.raises(ValueError, match="length of --token = 5 characters"):
        Door("0.0.0.0", "short")


def test_with_a_token_only_those_come_in_who_know_it(client):
    outside = client(Door("0.0.0.0", TOKEN), base="http://rig.example:8347")
    assert outside.get("/").status_code == 403
    assert outside.get("/?token=a-token-that-is-wrong").status_code == 403
    assert outside.get("/main.js", headers={"cookie": f"{COOKIE}=x"}).status_code == 403
    with pytest.raises(WebSocketDisconnect), outside.websocket_connect(OUTSIDE):
        pass
    fresh = client(Door("0.0.0.0", TOKEN), base="http://rig.example:8347")
    answer = fresh.get(f"/?token={TOKEN}", follow_redirects=False)
    assert (answer.status_code, answer.headers["location"]) == (303, "/")  # out of the address, where others look on
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert fresh.get("/").status_code == 200
    with fresh.websocket_connect(OUTSIDE) as socket:
        Page(socket).text("state")
    with (
        pytest.raises(WebSocketDisconnect),
        fresh.websocket_connect(OUTSIDE, headers={"origin": "http://evil.example"}),
    ):
        pass


def test_a_run_is_told_in_frames_that_are_as_long_as_the_page_expects(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket, {"a": "lqg", "b": "soft_torque", "seed": 5})
        state = page.text("state")
        assert (state["setting"]["a"], state["setting"]["b"], state["setting"]["seed"]) == ("lqg", "soft_torque", 5)
        assert state["setting"]["mu_s"] == 0.5
        frame = page.frame()
        kind, version, lanes, flags, steps, samples, run, first, period = struct.unpack_from("<BBBBHHIIf", frame)
        assert (kind, version, lanes, flags, samples, run, first) == (0x44, 1, 2, 0, 16, 0, 0)
        assert period == pytest.approx(0.1)
        channels = [len(lane["channels"]) for lane in state["lanes"]]
        assert len(frame) == frame_bytes(steps, channels)
        given = np.frombuffer(frame, "<f4", steps * len(COLUMNS), HEADER_BYTES)
        np.testing.assert_allclose(given[:5], [10.0, 0.5, 0.306, 1.0, 2.5], rtol=1e-6)


def test_maps_follow_what_is_given_at_once(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket)
        before = page.text("charts")
        assert before["lanes"][0]["map"]["critical_now"] == pytest.approx(1.9949, abs=1e-3)
        assert before["lanes"][0]["map"]["end_now"] == pytest.approx(2.9010, abs=1e-3)
        assert len(page.text("charts")["lanes"][0]["orbit"]["twist"]) > 100
        page.say("give", values={"normal_force": 20.0})
        began = time.perf_counter()
        after = page.text("charts")
        assert after["lanes"][0]["map"]["critical_now"] == pytest.approx(2.6881, abs=1e-3)
        assert (
            time.perf_counter() - began < 5.0
        )  # benchmarks.room measures it; here only that it is no matter of minutes


def test_every_control_is_answered_by_the_state(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket)
        page.text("state")
        page.say("pause", paused=True)
        assert page.text("state", paused=True)["times"] == 1.0
        page.say("speed", times=5)
        page.text("state", times=5.0)
        page.say("take", lane="B", reference=3.0)
        assert page.text("state")["lanes"][1]["hand"] == 3.0
        page.say("take", lane="A")
        assert page.text("state")["lanes"][0]["hand"] == pytest.approx(2.5)
        page.say("give_back", lane="B")
        assert page.text("state")["lanes"][1]["hand"] is None
        page.say("ramp", name="normal_force", to=25, seconds=5)
        assert page.text("state")["ramps"] == {"normal_force": 25.0}
        page.say("restart", new_seed=True)
        state = page.text("state", run=1)
        assert (state["setting"]["seed"], state["step"], state["paused"]) == (1, 0, True)
        page.say("step")
        assert page.text("state", step=1)["paused"]
        page.say("restart", new_seed=False)
        assert page.text("state", run=2)["setting"]["seed"] == 1
        page.say("set", setting={"rig": "field_2500m"})
        assert page.text("state", run=3)["setting"]["normal_force"] > 100.0


def test_values_given_before_the_first_step_are_those_of_the_start(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket)
        page.say("pause", paused=True)
        page.say("restart")
        page.text("state", paused=True, step=0)
        page.say("give", values={"normal_force": 21.0})
        page.text("state", step=0)
        page.say("step")
        page.text("state", step=1)
        page.say("keep", what="run")
        run = Recorded.of(json.loads(page.text("file")["text"]))
        assert run.course.values("normal_force").tolist() == [21.0]


def test_a_run_that_is_kept_is_the_environments_and_is_played_again(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket, {"a": "z_torque", "sensors": "surface", "b": "ppo_surface", "seed": 4})
        page.say("pause", paused=True)
        for step in range(30):
            page.say("step")
            if step == 10:
                page.say("give", values={"normal_force": 17.5})
        page.text("state", step=30)
        page.say("keep", what="csv")
        lines = page.text("file")["text"].splitlines()
        assert lines[0].startswith("time [s],normal_force [N],mu_s,mu_k,v_b [s/rad],speed_target [rad/s],A_action")
        assert len(lines) == 31
        page.say("keep", what="run")
        kept = json.loads(page.text("file")["text"])
        run = Recorded.of(kept)
        column = lines[0].split(",").index("B_bit_speed [rad/s]")
        env = DrillRigEnv(**run.environment("B"))
        env.reset(**run.reset)
        for line, action in zip(lines[1:], run.actions("B"), strict=True):
            env.step(action)
            assert line.split(",")[column] == f"{env.core.episodes['state'][0, 2]:.10g}"
        page.say("replay", run=kept)
        assert page.text("state", replay=True)["lanes"][1]["policy"] == "ppo_surface"


def test_a_run_of_another_rig_is_played_from_the_command_line_alone(client):
    lanes = Lanes(Setting(rig="own", b="constant"), Stock.of(Rig(J_1=0.03)))
    lanes.step()
    run = lanes.as_recorded()
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket)
        page.say("replay", run=run.as_json())
        assert "its rig is none of this room's" in page.text("refused")["sentence"]
    with client(recorded=run).websocket_connect(ROOM) as socket:
        page = Page(socket)
        assert page.text("state", at_end=True)["replay"]


def test_a_rig_that_is_lost_stops_the_clock_and_says_so(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket)
        page.say("speed", times=10)
        page.text("state", times=10.0)
        page.frame()
        page.say("give", values={"normal_force": 1e12})
        refused = page.text("refused")
        assert refused["field"] == "run"
        assert "the run has stopped, restart it" in refused["sentence"]
        assert page.text("state", paused=True)["at_end"]
        page.say("give", values={"normal_force": 10})
        page.say("restart")
        assert not page.text("state", run=1)["at_end"]


@pytest.mark.slow
def test_every_part_of_every_story_can_be_told(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket)
        for name, story in STORIES.items():
            for part in range(len(story.parts)):
                page.say("story", name=name, part=part)
                page.text("state", story={"name": name, "part": part})
        page.say("story", name="")
        assert page.text("state", story=None)


REFUSALS = [
    ({"do": "give", "values": {"normal_force": -1}}, "normal_force", "normal_force = -1 N is not allowed"),
    ({"do": "give", "values": {"mu_k": "soft"}}, "mu_k", "'soft' is not a number"),
    ({"do": "set", "setting": {"delay": 99}}, "delay", "delay = 99 control steps"),
    ({"do": "set", "setting": {"a": "ppo_surface"}}, "a", "ppo_surface sees current"),
    ({"do": "ramp", "name": "normal_force", "to": 5, "seconds": -1}, "ramp normal_force", "time of a ramp = -1 s"),
    ({"do": "take", "lane": "A", "reference": 11}, "hand A", "speed_reference = 11 rad/s"),
    ({"do": "take", "lane": "C"}, "hand C", "lane 'C' is not known"),
    ({"do": "speed", "times": 11}, "speed", "speed = 11 times real time is not allowed; allowed: >= 0.1 and <= 10"),
    ({"do": "speed", "times": 0}, "speed", "speed = 0 times real time"),
    ({"do": "story", "name": "bistabilty"}, "story", "did you mean bistability?"),
    ({"do": "story", "name": "bistability", "part": 7}, "story", "part 7 is not there"),
    ({"do": "keep", "what": "/etc/passwd"}, "keep", "cannot be kept"),
    ({"do": "replay", "run": {"format": "x"}}, "replay", "not a recorded run"),
    ({"do": "begin", "version": 1}, "begin", "has begun already"),
]
"""Messages, the field beside which the refusal belongs, and what it says."""


def test_what_is_not_allowed_is_told_beside_its_field_and_changes_nothing(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket, {"sensors": "encoders"})
        page.say("pause", paused=True)
        before = page.text("state", paused=True)
        for message, field, sentence in REFUSALS:
            socket.send_text(json.dumps(message))
            refused = page.text("refused")
            assert refused["field"] == field, message
            assert sentence in refused["sentence"], message
            assert page.text("state") == before, message


NO_MESSAGES = [
    "", "{", "[]", "null", '{"do":"fly"}', '{"do":"pause"}', '{"do":"pause","paused":1}', '{"paused":true}',
    '{"do":"pause","paused":true,"more":1}', '{"do":"give","values":{"mu_s":NaN}}', '{"do":"give","values":[1]}',
    '{"do":"set","setting":{"a":{"b":1}}}', '{"do":"speed","times":1e999}', "[" * 2000, '{"do":"take","lane":1}',
    '{"do":"begin"}', '{"do":"replay","run":7}', "\x00", "\ufeff{}",
]  # fmt: skip


def test_what_is_no_message_is_refused_and_the_room_goes_on(client):
    with client(limits=Limits(mistakes=100)).websocket_connect(ROOM) as socket:
        page = Page(socket)
        page.text("state")
        for text in NO_MESSAGES:
            socket.send_text(text)
            assert page.text("refused")["sentence"].startswith("control room: not a message"), text
        page.say("pause", paused=True)
        page.text("state", paused=True)


def test_bytes_are_no_message(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket)
        socket.send_bytes(b"\x00" * 100)
        assert "not bytes" in page.text("refused")["sentence"]


def sent_away(page):
    """The code with which a page is sent away."""
    while True:
        message = page.socket.receive()
        if message["type"] == "websocket.close":
            return message["code"]


def test_whoever_says_nothing_of_the_protocol_for_long_is_sent_away(client):
    with client(limits=Limits(mistakes=5)).websocket_connect(ROOM) as socket:
        page = Page(socket)
        for _ in range(7):
            socket.send_text("nonsense")
        assert sent_away(page) == REFUSED


def test_a_flood_is_cut_off(client):
    with client(limits=Limits(messages=1.0, burst=20)).websocket_connect(ROOM) as socket:
        page = Page(socket)
        for _ in range(40):
            page.say("alive")
        assert sent_away(page) == REFUSED


def test_a_message_that_is_too_long_is_not_read(client):
    limits = Limits(message_bytes=1000, run_bytes=5000)
    for text in ('{"do":"give","values":{"' + "x" * 1000 + '":1}}', '{"do":"replay","run":{"' + "x" * 5000 + '":1}}'):
        with client(limits=limits).websocket_connect(ROOM) as socket:
            page = Page(socket)
            socket.send_text(text)
            assert sent_away(page) == TOO_BIG


def test_whoever_is_idle_or_never_begins_is_sent_away(client):
    with client(limits=Limits(idle=0.2)).websocket_connect(ROOM) as socket:
        assert sent_away(Page(socket)) == REFUSED
    with client(limits=Limits(first=0.2)).websocket_connect(ROOM) as socket:
        socket.receive_text()
        message = socket.receive()
        assert (message["type"], message["code"]) == ("websocket.close", REFUSED)
        assert message["reason"] == "nothing was heard for 0.2 s: load the page again"


def test_another_version_of_the_page_is_told_to_load_again(client):
    with client().websocket_connect(ROOM) as socket:
        assert sent_away(Page(socket, version=2)) == REFUSED


def test_more_pages_than_allowed_are_turned_away_until_one_leaves(client):
    one = client(limits=Limits(clients=1))
    with one.websocket_connect(ROOM) as first:
        Page(first).text("state")
        with one.websocket_connect(ROOM) as second, pytest.raises(WebSocketDisconnect) as away:
            second.receive_text()
        assert away.value.code == TOO_MANY
    deadline = time.monotonic() + 5.0
    while True:
        with one.websocket_connect(ROOM) as third:
            try:
                Page(third).text("state")
                break
            except WebSocketDisconnect:
                assert time.monotonic() < deadline


def test_each_page_has_its_own_rig(client):
    room = client()
    with room.websocket_connect(ROOM) as one, room.websocket_connect(ROOM) as other:
        first, second = Page(one), Page(other)
        first.text("state")
        first.say("give", values={"normal_force": 3.0})
        second.say("pause", paused=True)
        assert second.text("state", paused=True)["setting"]["normal_force"] == 10.0
        while first.text("state")["setting"]["normal_force"] != 3.0:
            pass


def test_a_link_that_cannot_be_is_told_and_another_room_begins(client):
    with client().websocket_connect(ROOM) as socket:
        page = Page(socket, {"normal_force": -4, "rig": "laboratory"})
        refused = page.text("refused")
        assert (refused["field"], "normal_force = -4" in refused["sentence"]) == ("link", True)
        assert page.text("state")["setting"]["normal_force"] == 10.0


def test_a_story_of_the_command_line_begins_at_once(client):
    with client(story="delay", full_screen=True).websocket_connect(ROOM) as socket:
        page = Page(socket)
        assert page.welcome["begin"] == {"story": "delay", "full_screen": True}
        assert page.text("state")["story"] == {"name": "delay", "part": 0}
