"""The same work on many parts, by several processes side by side: results come as they are done."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import Any, Self, TypeVar

from drillrig_env.command_line import Failed, deaf_to_interrupt

P = TypeVar("P")
R = TypeVar("R")


class Workers:
    """Up to `jobs` processes, which begin with the first work that has several parts, and end with the block.

    They are spawned: what they run must be importable, and a script that has them must do its work below
    `if __name__ == "__main__"`. They do not hear Ctrl-C; where it comes in the midst of some work they are ended.
    """

    def __init__(self, jobs: int = 1) -> None:
        self.jobs = jobs
        self._processes: dict[Connection, BaseProcess] = {}
        self._known: dict[Connection, Any] = {}  # the work that each has already, which may be large

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()

    def each(self, work: Callable[[P], R], parts: Sequence[P]) -> Iterator[tuple[int, R]]:
        """The number of each part and what `work` makes of it, in the order in which they are done.

        What `work` raises comes out here. `Failed` where a process ends in the midst of it, as for want of memory.
        """
        if min(self.jobs, len(parts)) <= 1:
            yield from ((number, work(part)) for number, part in enumerate(parts))
            return
        try:
            self._begin(min(self.jobs, len(parts)))
            waiting = list(enumerate(parts))[::-1]
            idle, running = list(self._processes), dict[Connection, int]()
            while waiting or running:
                while waiting and idle:
                    pipe = idle.pop()
                    number, part = waiting.pop()
                    running[pipe] = number
                    with suppress(OSError):  # one that has ended is told of below
                        pipe.send((None if self._known.get(pipe) is work else work, part))
                    self._known[pipe] = work
                ready = wait(list(running))
                for pipe in [one for one in running if one in ready]:
                    result = self._received(pipe)
                    idle.append(pipe)
                    yield running.pop(pipe), result
        except BaseException:
            self.end()
            raise

    def map(self, work: Callable[[P], R], parts: Iterable[P]) -> list[R]:
        """What `work` makes of each part, in the order of the parts."""
        return [result for _, result in sorted(self.each(work, list(parts)), key=lambda one: one[0])]

    def end(self) -> None:
        """End the processes, whatever they do."""
        for process in self._processes.values():
            process.terminate()
        for pipe, process in self._processes.items():
            process.join()
            pipe.close()
        self._processes.clear()
        self._known.clear()

    def _begin(self, count: int) -> None:
        context = get_context("spawn")
        with deaf_to_interrupt():
            while len(self._processes) < count:
                here, there = context.Pipe()
                process = context.Process(target=_run, args=(there,), daemon=True)
                process.start()
                there.close()
                self._processes[here] = process

    def _received(self, pipe: Connection) -> Any:
        try:
            result, error = pipe.recv()
        except (EOFError, OSError):
            process = self._processes[pipe]
            process.join()
            raise Failed(
                f"calibrate: one of {self.jobs} processes ended with code {process.exitcode}; give it more memory or "
                'fewer jobs, and have a script that starts them below if __name__ == "__main__"'
            ) from None
        if error is not None:
            raise error
        return result


def _run(pipe: Connection) -> None:
    """Work until the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    work: Any = None
    with suppress(EOFError, OSError):  # the other end has gone
        while True:
            new, part = pipe.recv()
            work = work if new is None else new
            answer: tuple[Any, Exception | None]
            try:
                answer = work(part), None
            except Exception as error:
                answer = None, error
            pipe.send(answer)
