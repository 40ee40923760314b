"""One stock for all tests of the room, a client of a server with a page of one file, and the true page in a browser."""

import re

import pytest

from drillrig_env.room.page import PageFile
from drillrig_env.room.stock import Stock


@pytest.fixture(scope="session")
def stock():
    return Stock.of()


@pytest.fixture
def files():
    index = PageFile(b"<!doctype html><title>room</title>", "text/html; charset=utf-8")
    return {"/": index, "/main.js": PageFile(b"export {};", "text/javascript; charset=utf-8")}


@pytest.fixture
def client(stock, files):
    """A client of a room that waits for no one long."""
    from starlette.testclient import TestClient

    from drillrig_env.room.app import room_app
    from drillrig_env.room.client import Beginning
    from drillrig_env.room.door import Door
    from drillrig_env.room.setting import Setting
    from tests.room.visitor import HERE

    def client(door=None, limits=None, base=HERE, known=stock, **beginning):
        room = room_app(known, files, Beginning(Setting(b="constant"), **beginning), door or Door("127.0.0.1"), limits)
        return TestClient(room, base_url=base)

    return client


@pytest.fixture(scope="module")
def served():
    """A server of the true page."""
    from benchmarks.browser import Room

    room = Room(("--port", "0"))
    yield room
    room.close()


@pytest.fixture(scope="module")
def browser():
    from benchmarks.browser import chromium

    with chromium() as found:
        yield found


@pytest.fixture
def visit(browser):
    """A page at an address, which must not complain."""
    from benchmarks.browser import is_drawn

    contexts, complaints = [], []

    def visit(address, size=(1440, 900), **settings):
        context = browser.new_context(viewport={"width": size[0], "height": size[1]}, accept_downloads=True, **settings)
        contexts.append(context)
        page, own = context.new_page(), (re.match(r"http://[^/]+", address)[0], "blob:", "data:")
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
        page.on("request", lambda asked: None if asked.url.startswith(own) else complaints.append(asked.url))
        page.goto(address)
        is_drawn(page)
        return page

    yield visit
    for context in contexts:
        context.close()
    assert [said for said in complaints if "ERR_CONNECTION_REFUSED" not in said and "WebSocket" not in said] == []


@pytest.fixture
def page(visit, served):
    return visit(served.address)
