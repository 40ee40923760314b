"""Ctrl-C and SIGTERM as a wish: the loop goes on and stops the rig first. The second one ends at once."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from drillrig_env.command_line import Terminated


@dataclass
class Stopping:
    """Whether somebody has `asked` to stop, and how, in words; empty as long as nobody has."""

    asked: str = ""
    number: int = 0

    def as_exception(self) -> KeyboardInterrupt:
        """What the first wish would have raised elsewhere."""
        return Terminated() if self.number == signal.SIGTERM else KeyboardInterrupt()


@contextmanager
def asked_to_stop() -> Iterator[Stopping]:
    """While the block runs, in the main thread, keep the first Ctrl-C or SIGTERM as a wish; raise at the second."""
    stopping = Stopping()

    def ask(number: int, _frame: object) -> None:
        again = bool(stopping.asked)
        stopping.asked, stopping.number = "SIGTERM" if number == signal.SIGTERM else "Ctrl-C", number
        if again:
            raise stopping.as_exception()

    earlier = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stopping
    finally:
        for number, handler in earlier.items():
            signal.signal(number, handler)
