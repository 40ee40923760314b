"""Work for engines: functions that other processes import."""

import os
import signal
import sys
import time

from drillrig_env.engine.worker import stop_asked
from drillrig_env.jit.threads import check_threads


def square(piece):
    return piece**2


def cube(piece):
    return piece**3


def process(_piece):
    return os.getpid()


def threads(_piece):
    return check_threads(None)


def refused(piece):
    if piece == 1:
        raise ValueError(f"{piece} is not allowed")
    if piece == 2:
        sys.exit("the end")
    return piece


def killed(piece):
    if piece == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return piece


def killed_once(piece):
    """Kill the process that is first to do the third piece; `piece` is a number and a folder."""
    number, folder = piece
    if number == 2 and not (folder / "killed").exists():
        (folder / "killed").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def until_stopped(folder):
    """Say that it has begun, and go on until a stop is asked for."""
    folder.with_suffix(".begun").touch()
    while not stop_asked():
        time.sleep(0.02)
    return "stopped"


def without_end(piece):
    """Hear of no stop; `piece` is a file to write one's number into."""
    piece.write_text(str(os.getpid()))
    time.sleep(600.0)
