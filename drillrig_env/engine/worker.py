"""What runs in a process that does pieces for another one: the work, kept from piece to piece, and how it is stopped.

Pieces of the same work come one after another, and the work may be large: it is unpacked once.
"""

from __future__ import annotations

import _thread
import os
import platform
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from drillrig_env.engine.contract import Outcome, innermost
from drillrig_env.engine.likeness import check_alike, likeness, processor
from drillrig_env.engine.packing import packed, packed_error, unpacked
from drillrig_env.jit.threads import use_threads

SAVE, LEAVE = 2.5, 3.5
"""Seconds after a stop at which a piece that is apart is to save at once, and at which its process ends."""

Answer = tuple[bytes | None, bytes | None, str, str]
"""Of a piece: its result packed, or its error, the innermost calls of that, and the processor."""

_works: dict[str, Any] = {}
_stopping = threading.Event()


def stop_asked() -> bool:
    """Whether the piece that this process is at should come to its end, and keep what it has."""
    return _stopping.is_set()


def packed_work(work: Any) -> bytes:
    """Work as bytes, with the likeness of the process that asks for it."""
    return packed((dict(likeness()), packed(work)))


def answer(key: str, content: bytes, piece: bytes) -> Answer:
    """Do a packed piece of the work of this `key`, which is in `content` as `packed_work` has made it.

    The work is unpacked where it is not known here, and this process is to compute as the one that asks.
    """
    use_threads(1)  # a machine's cores are shared by pieces
    try:
        if key not in _works:
            wanted, work = unpacked(content)
            check_alike(wanted, f"the machine {platform.node()}")
            _works.clear()
            _works[key] = unpacked(work)
        result = packed(_works[key](unpacked(piece)))
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # a stranger's policy may raise anything, and may ask for the end of the process
        return None, packed_error(error), innermost(error), processor()
    return result, None, "", processor()


def opened(number: int, told: Answer, elsewhere: bool = False) -> Outcome[Any]:
    """The outcome that an answer tells of; `elsewhere` where another machine may have given it."""
    result, error, calls, name = told
    name = name if elsewhere else ""
    if error is not None:
        return Outcome(number, error=unpacked(error), calls=calls, processor=name)
    return Outcome(number, None if result is None else unpacked(result), processor=name)


def answer_from_file(path: Path, piece: bytes) -> Answer:
    """Do a packed piece of the work in a file, in a process beside the one that asks."""
    return answer(path.name, b"" if path.name in _works else path.read_bytes(), piece)


def begin(held: Connection, apart: bool) -> None:
    """Begin a process beside the one that asks: deaf to Ctrl-C, and gone where that lets go of the pipe, or is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_watch, args=(held, apart), daemon=True).start()


def _watch(held: Connection, apart: bool) -> None:
    """Wait until the other end of the pipe is let go; then let a piece that is apart save, and end the process."""
    with suppress(EOFError, OSError):
        held.recv_bytes()
    if apart:
        _stopping.set()
        time.sleep(SAVE)
        _thread.interrupt_main(signal.SIGTERM)
        time.sleep(LEAVE - SAVE)
    os._exit(1)


@contextmanager
def asked_by_interrupt() -> Iterator[None]:
    """While the block runs an interrupt asks for a stop, and a second one is raised: by these a cluster cancels."""
    _stopping.clear()

    def ask(_number: int, _frame: object) -> None:
        if _stopping.is_set():
            raise KeyboardInterrupt
        _stopping.set()

    earlier = signal.signal(signal.SIGINT, ask)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, earlier)
