"""A thread for each client: what a policy works out there holds up no other client, and can end nothing but itself."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from queue import SimpleQueue
from typing import Any, TypeAlias, TypeVar

T = TypeVar("T")

PATIENCE = 60.0
"""s until whatever has not come back is given up: no less than the kernels take to be compiled on a busy machine."""

_MOST_LOST = 3
"""Threads of one client that may be given up, at most: what they do goes on for as long as the server."""

_Todo: TypeAlias = "SimpleQueue[tuple[Callable[[], Any], asyncio.Future[Any]] | None]"


class Worker:
    """Does one thing after another in a thread of its own, which is waited for without holding up the event loop.

    The thread is a daemon: nothing that does not come back keeps the server from its end. `patience` is in s, None
    for ever.
    """

    def __init__(self, patience: float | None = PATIENCE) -> None:
        self._patience, self._lost = patience, 0
        self._todo: _Todo | None = None

    async def do(self, work: Callable[[], T]) -> T:
        """What `work` returns. Raises what it raises, and `TimeoutError` with a sentence where it does not come back.

        What would end the program, or the waiting, is a `RuntimeError` instead.
        """
        if self._lost == _MOST_LOST:
            raise TimeoutError(f"{_MOST_LOST} things have not come back; load the page again")
        done: asyncio.Future[T] = asyncio.get_running_loop().create_future()
        if self._todo is None:
            self._todo = SimpleQueue()
            threading.Thread(target=_work, args=(self._todo,), daemon=True).start()
        self._todo.put((work, done))
        try:
            return await asyncio.wait_for(done, self._patience)
        except TimeoutError as error:
            if not done.cancelled():  # the work's own
                raise
            self.close()
            self._lost += 1
            raise TimeoutError(f"nothing came back within {self._patience:g} s, and it is not waited for") from error

    def close(self) -> None:
        """Let the thread end with what it is at."""
        if self._todo is not None:
            self._todo.put(None)
            self._todo = None


def _work(todo: _Todo) -> None:
    while (task := todo.get()) is not None:
        work, done = task
        result, error = None, None
        try:
            result = work()
        except BaseException as raised:  # a stranger's policy may raise anything, SystemExit among it
            plain = isinstance(raised, Exception) and not isinstance(raised, StopIteration)
            error = raised if plain else RuntimeError(f"{type(raised).__name__} was raised: {raised}")
        with suppress(RuntimeError):  # the server has ended meanwhile
            done.get_loop().call_soon_threadsafe(_settle, done, result, error)
        del task, work, done, result, error  # nothing is kept while nothing is done


def _settle(done: asyncio.Future[Any], result: Any, error: BaseException | None) -> None:
    if done.done():
        return
    if error is None:
        done.set_result(result)
    else:
        done.set_exception(error)
