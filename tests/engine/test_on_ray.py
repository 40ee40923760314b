"""Pieces of work on Ray: what is lost is done again, what fails is told of, and a stop leaves nothing behind."""

import os
import signal
import threading
import time
from pathlib import Path

import pytest

from drillrig_env.command_line import Failed
from drillrig_env.engine import Local, engine_at, worker
from tests.engine.work import cube, killed, killed_once, process, refused, square, threads, until_stopped

pytest.importorskip("ray")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name == "nt", reason="signals")]


@pytest.fixture(scope="module")
def engine():
    handlers = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with engine_at("ray", 2) as found:
        assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == handlers
        yield found
        folder = Path(found._folder)
    assert not folder.exists()


def test_two_workers_do_what_one_process_does(engine):
    assert not engine.here
    assert engine.map(square, range(30)) == Local().map(square, range(30))
    assert engine.map(cube, range(3)) == [0, 1, 8]
    assert os.getpid() not in engine.map(process, range(4))
    assert engine.map(threads, range(2)) == [1, 1]
    assert engine.processors == {worker.processor()}


def test_a_worker_that_is_killed_loses_nothing(engine, tmp_path):
    assert engine.map(killed_once, [(number, tmp_path) for number in range(6)]) == list(range(6))
    assert (tmp_path / "killed").exists()


def test_what_fails_for_a_reason_of_its_own_is_told_of(engine):
    found = sorted(engine.outcomes(refused, range(4)), key=lambda one: one.number)
    assert [str(one.error or one.result) for one in found] == ["0", "1 is not allowed", "the end", "3"]
    assert found[1].calls.rstrip().endswith('raise ValueError(f"{piece} is not allowed")')


def test_a_piece_that_kills_each_of_its_workers_is_given_up(engine):
    found = {one.number: one for one in engine.outcomes(killed, range(3))}
    assert (found[0].result, found[2].result) == (0, 2)
    with pytest.raises(Failed, match="a piece was lost 4 times: WorkerCrashedError"):
        found[1].value()


def test_pieces_that_are_apart_come_to_their_end_when_stopped(engine, tmp_path):
    def interrupt():
        while len(list(tmp_path.glob("*.begun"))) < 2:
            time.sleep(0.02)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt, daemon=True).start()
    found = []
    with pytest.raises(KeyboardInterrupt):
        found.extend(one.result for one in engine.outcomes(until_stopped, [tmp_path / "0", tmp_path / "1"], apart=True))
    assert found == ["stopped", "stopped"]
    assert engine.map(square, [2, 3]) == [4, 9]


def test_a_worker_of_another_version_is_refused(engine, monkeypatch):
    other = {**worker.likeness(), "kernels": "0123456789abcdef"}
    monkeypatch.setattr(worker, "likeness", lambda: other)
    with pytest.raises(Failed, match=r"does not compute as .* asks it: it has kernels \w+ and not 0123"):
        engine.map(refused, [0])


def test_a_second_instance_in_one_process_is_refused(engine):
    with pytest.raises(Failed, match="Ray has been started in this process already"):
        engine_at("ray").begin()
