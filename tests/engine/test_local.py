"""Pieces of work in this process, and in processes beside it."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from drillrig_env.command_line import Failed
from drillrig_env.engine import Local
from drillrig_env.modules import load_module
from tests.engine.work import cube, killed, process, refused, square, threads, until_stopped

ROOT = Path(__file__).parents[2]
POSIX = pytest.mark.skipif(os.name == "nt", reason="signals")


def test_one_job_works_in_this_process():
    with Local() as engine:
        assert engine.here
        assert list(engine.each(process, [0, 0])) == [(0, os.getpid()), (1, os.getpid())]


def test_pieces_are_taken_when_there_is_room():
    taken = []

    def pieces():
        for number in range(3):
            taken.append(number)
            yield number

    for number, _ in Local().each(square, pieces()):
        assert taken == list(range(number + 1))


def test_what_a_piece_raises_is_its_outcome_here():
    found = list(Local().outcomes(refused, range(4)))
    assert [(one.number, one.result, str(one.error or "")) for one in found] == [
        (0, 0, ""),
        (1, None, "1 is not allowed"),
        (2, None, "the end"),
        (3, 3, ""),
    ]
    assert found[1].calls.rstrip().endswith('raise ValueError(f"{piece} is not allowed")')
    with pytest.raises(ValueError, match="1 is not allowed"):
        Local().map(refused, range(4))


def test_several_do_what_one_does(tmp_path):
    """Results in the order of the pieces, other work by the same processes, errors as they are, a file of one's own."""
    own = tmp_path / "own.py"
    own.write_text("class Power:\n    def __init__(self, n):\n        self.n = n\n    def __call__(self, x):\n")
    own.write_text(
        own.read_text() + "        return x**self.n\nclass Odd(Exception):\n    def __init__(self, a, b): ...\n"
    )
    module = load_module(own)
    with Local(2) as engine:
        assert engine.map(square, range(7)) == [0, 1, 4, 9, 16, 25, 36]
        processes = set(engine.map(process, range(4)))
        assert os.getpid() not in processes
        assert engine.map(cube, range(3)) == [0, 1, 8]
        assert set(engine.map(process, range(4))) <= processes | set(engine.map(process, range(4)))
        assert engine.map(threads, range(2)) == [1, 1]
        assert engine.map(module.Power(4), [2, 3]) == [16, 81]
        found = sorted(engine.outcomes(refused, range(4)), key=lambda one: one.number)
        assert [str(one.error or one.result) for one in found] == ["0", "1 is not allowed", "the end", "3"]
        assert type(found[1].error) is ValueError
        assert found[1].calls.rstrip().endswith('raise ValueError(f"{piece} is not allowed")')
        folder = engine._folder
        assert len(list(folder.iterdir())) == 1  # the work that is known, and none before it
    assert not folder.exists()


@POSIX
def test_a_process_that_is_killed_is_told_of():
    with Local(2) as engine:
        with pytest.raises(Failed, match="one of 2 processes ended in the midst of its work; give it more memory"):
            list(engine.outcomes(killed, [1, 1, 1]))
        assert engine.map(square, [2, 3]) == [4, 9]  # and others take its place


@POSIX
def test_pieces_that_are_apart_share_no_process_and_no_end():
    with Local(2) as engine:
        found = {one.number: one for one in engine.outcomes(killed, range(3), apart=True)}
        assert (found[0].result, found[2].result) == (0, 2)
        assert isinstance(found[1].error, Failed)
        assert len({one.result for one in engine.outcomes(process, range(3), apart=True)}) == 3


@POSIX
def test_a_piece_that_is_apart_comes_to_its_end_when_stopped(tmp_path):
    pieces = [tmp_path / "0", tmp_path / "1", tmp_path / "2"]

    def interrupt():
        while len(list(tmp_path.glob("*.begun"))) < 2:
            time.sleep(0.02)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt, daemon=True).start()
    found = []
    with Local(2) as engine, pytest.raises(KeyboardInterrupt):
        found.extend((one.number, one.result) for one in engine.outcomes(until_stopped, pieces, apart=True))
    assert sorted(found) == [(0, "stopped"), (1, "stopped")]  # and the third has not begun


@POSIX
@pytest.mark.parametrize("apart", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_processes_end_with_the_one_that_asked(apart, tmp_path):
    """It is killed, and they hear of no stop."""
    program = (
        "import pathlib, sys\nfrom drillrig_env.engine import Local\nfrom tests.engine.work import without_end\n"
        "if __name__ == '__main__':\n    pieces = [pathlib.Path(sys.argv[1], str(k)) for k in range(2)]\n"
        f"    list(Local(2).outcomes(without_end, pieces, apart={apart}))\n"
    )
    (tmp_path / "program.py").write_text(program)
    folder = tmp_path / "numbers"
    folder.mkdir()
    begun = subprocess.Popen(
        [sys.executable, str(tmp_path / "program.py"), str(folder)], env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
    try:
        wait_for(
            lambda: [path.read_text() for path in folder.iterdir()].count("") == 0 and len(list(folder.iterdir())) == 2
        )
    finally:
        begun.kill()
        begun.wait()
    numbers = [int(path.read_text()) for path in folder.iterdir()]
    wait_for(lambda: not any(map(is_running, numbers)), 10.0)


def is_running(number):
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_for(true, seconds=60.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)
