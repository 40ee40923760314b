"""Who is let in, by which names and with what, and what is served: nothing of the machine."""

import pytest

pytest.importorskip("starlette", reason="needs the extra room")

from starlette.websockets import WebSocketDisconnect

from drillrig_env.room import app
from drillrig_env.room.client import REFUSED
from drillrig_env.room.door import COOKIE, Door
from tests.room.visitor import HERE, ROOM, Page

OUTSIDE = f"ws://rig.example:8347{app.ROOM}"


TOKEN = "a-token-that-is-long"


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
