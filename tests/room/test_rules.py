"""What is too much: floods, long messages, no messages, silence, and more pages than there may be."""

import time

import pytest

pytest.importorskip("starlette", reason="needs the extra room")

from starlette.websockets import WebSocketDisconnect

from drillrig_env.room.client import REFUSED, TOO_BIG, TOO_MANY
from drillrig_env.room.limits import Limits
from tests.room.visitor import ROOM, Page, sent_away

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
