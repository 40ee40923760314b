"""One stock for all tests of the room, and a page of one file."""

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
