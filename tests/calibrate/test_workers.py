"""Processes that work side by side."""

import os
import signal

import pytest

from drillrig_env.calibrate.workers import Workers
from drillrig_env.command_line import Failed


def square(part):
    return part**2


def cube(part):
    return part**3


def refused(part):
    raise ValueError(f"{part} is not allowed")


def killed(part):
    os.kill(os.getpid(), signal.SIGKILL)


def test_one_process_works_here():
    with Workers() as workers:
        assert list(workers.each(lambda part: part + os.getpid(), [0, 0])) == [(0, os.getpid()), (1, os.getpid())]


def test_results_come_in_the_order_of_the_parts():
    with Workers(2) as workers:
        assert workers.map(square, range(7)) == [0, 1, 4, 9, 16, 25, 36]
        assert workers.map(cube, range(3)) == [0, 1, 8]  # other work by the same processes


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_several_work_side_by_side_and_tell_what_goes_wrong():
    with Workers(2) as workers:
        assert dict(workers.each(square, [1, 2, 3, 4])) == {0: 1, 1: 4, 2: 9, 3: 16}
        with pytest.raises(ValueError, match="is not allowed"):
            list(workers.each(refused, [1, 2]))
        with pytest.raises(Failed, match="one of 2 processes ended with code -9; give it more memory"):
            list(workers.each(killed, [1, 2]))
