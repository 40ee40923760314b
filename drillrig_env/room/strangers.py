"""What code of others raises, told in a sentence that says whose it is; none of it ends the room."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from drillrig_env.policy.finding import UnknownPolicyError


@contextmanager
def named(whose: str) -> Iterator[None]:
    """Whatever is raised in the block comes out as a `ValueError` that begins with `whose` it is.

    Ctrl-C passes: it is raised in the main thread, and nobody else's. So does what says that there is no such policy.
    """
    try:
        yield
    except UnknownPolicyError:
        raise
    except BaseException as error:  # a stranger's policy may raise anything, and may ask for the end of the process
        if isinstance(error, KeyboardInterrupt) and threading.current_thread() is threading.main_thread():
            raise
        raise ValueError(f"{whose}: {said(error)}") from error


def said(error: BaseException) -> str:
    """What an error says on one line, with its type and place where it is none that is meant to be read."""
    try:
        words = " ".join(str(error).split())
    except Exception:  # its words are a stranger's as well
        words = ""
    if isinstance(error, ValueError | ImportError | TimeoutError) and words:
        return words
    calls = traceback.extract_tb(error.__traceback__)
    place = f" in {Path(calls[-1].filename).name}, line {calls[-1].lineno}" if calls else ""
    return f"{type(error).__name__}{place if not isinstance(error, SyntaxError) else ''}{': ' if words else ''}{words}"
