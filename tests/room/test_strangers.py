"""Policies of others: whatever they raise, however long they take, the room says whose it is and goes on."""

import asyncio
import threading
import time
from functools import partial

import pytest

pytest.importorskip("starlette", reason="needs the extra room")

from drillrig_env.room import protocol
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.session import Session
from drillrig_env.room.setting import Setting
from drillrig_env.room.stock import Stock
from drillrig_env.room.worker import Worker
from tests.room.visitor import ROOM, Page

POLICIES = """
import sys
import time

import numpy as np


class Policy:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.full((1, 1), self.act(), dtype=np.float32), None


class Slow(Policy):
    def act(self):
        time.sleep(0.4)
        return 0.25


class Exits(Policy):
    def act(self):
        sys.exit("enough")


class Interrupts(Policy):
    def act(self):
        raise KeyboardInterrupt


class Stops(Policy):
    def act(self):
        raise StopIteration


class Mute(Exception):
    def __str__(self):
        raise ValueError


class Wordless(Policy):
    def act(self):
        raise Mute


class NoNumber(Policy):
    def act(self):
        return float("nan")


class ExitsWhenMade(Policy):
    def __init__(self):
        sys.exit(3)


class ExitsWhenAsked(Policy):
    @property
    def sensors(self):
        raise SystemExit
"""

ACTING = {
    "Exits": "SystemExit in policies.py, line 21: enough",
    "Interrupts": "KeyboardInterrupt in policies.py, line 26",
    "Stops": "StopIteration in policies.py, line 31",
    "Wordless": "Mute in policies.py, line 41",
    "NoNumber": "nan",
}
MADE = {
    "ExitsWhenMade": "SystemExit in policies.py, line 51: 3",
    "ExitsWhenAsked": "SystemExit in policies.py, line 57",
}
"""What is said of each, while it acts and when it is made."""


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    file = tmp_path_factory.mktemp("strangers") / "policies.py"
    file.write_text(POLICIES)
    return Stock.of(policies=[f"{file}:{name}" for name in ("Slow", *ACTING, *MADE)])


@pytest.mark.parametrize("name", ACTING)
def test_a_policy_that_fails_stops_its_run_and_is_named(client, known, name):
    with client(known=known).websocket_connect(ROOM) as socket:
        page = Page(socket)
        page.text("state")
        page.say("set", setting={"b": name})
        refused = page.text("refused")
        assert refused["field"] == "run"
        assert "the run has stopped, restart it: the policy of lane B: " in refused["sentence"]
        assert ACTING[name] in refused["sentence"]
        assert page.text("state", paused=True)["at_end"]
        page.say("set", setting={"b": "constant"})
        page.say("pause", paused=False)
        assert not page.text("state", run=2, paused=False)["at_end"]


@pytest.mark.parametrize("name", MADE)
def test_a_policy_that_cannot_be_made_leaves_the_run_as_it_was(client, known, name):
    with client(known=known).websocket_connect(ROOM) as socket:
        page = Page(socket, {"a": name})
        assert MADE[name] in page.text("refused", field="link")["sentence"]
        page.say("pause", paused=True)
        before = page.text("state", paused=True)
        page.say("set", setting={"a": name})
        refused = page.text("refused")
        assert (refused["field"], MADE[name] in refused["sentence"]) == ("a", True)
        assert page.text("state") == before


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("import nowhere_at_all", "cannot be read: No module named 'nowhere_at_all'"),
        ("1 / 0", "cannot be read: ZeroDivisionError in bad.py, line 1: division by zero"),
        ("raise SystemExit(4)", "cannot be read: SystemExit in bad.py, line 1: 4"),
        ("def (", "cannot be read: SyntaxError: invalid syntax (bad.py, line 1)"),
        ("\x00", "null bytes"),
        ("class Other: pass", "has no class 'Law'; allowed: Other"),
    ],
)
def test_a_file_that_cannot_be_read_is_told_at_the_start(tmp_path, content, sentence):
    file = tmp_path / "bad.py"
    file.write_text(content)
    with pytest.raises(ValueError, match=r"bad\.py") as refused:
        Stock.of(policies=[f"{file}:Law"])
    assert sentence in str(refused.value)


def test_two_policies_of_one_name_are_not_mistaken(tmp_path):
    for name in ("one", "other"):
        (tmp_path / f"{name}.py").write_text(f"class Law:\n    '''{name}'''")
    with pytest.raises(ValueError, match="there is another one that is called Law; rename its class"):
        Stock.of(policies=[f"{tmp_path}/{name}.py:Law" for name in ("one", "other")])


def test_a_slow_policy_holds_up_nobody_else(known):
    async def go():
        lanes = Lanes(Setting(b="Slow"), known)
        session, longest = Session(known, lanes, Worker()), 0.0
        run = asyncio.create_task(session.run())
        began = last = time.perf_counter()
        while last - began < 1.3:
            await asyncio.sleep(0.005)
            longest, last = max(longest, time.perf_counter() - last), time.perf_counter()
        await session.do(protocol.Pause(paused=True))
        assert session.paused
        run.cancel()
        return longest, session.lanes.step_number

    longest, steps = asyncio.run(go())
    assert longest < 0.2
    assert 1 <= steps <= 5


def test_what_never_comes_back_is_given_up_and_no_more_than_some_of_it():
    gate = threading.Event()

    async def go():
        worker = Worker(0.05)
        for lost in range(3):
            with pytest.raises(TimeoutError, match=r"nothing came back within 0.05 s"):
                await worker.do(gate.wait)
            if lost < 2:
                assert await worker.do(partial(int, "7")) == 7
        with pytest.raises(TimeoutError, match="load the page again"):
            await worker.do(partial(int, "7"))
        worker.close()

    asyncio.run(go())
    gate.set()
