"""Pieces of work on this machine: one after another in this process, or several in processes beside it."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Iterator, Sized
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Any, TypeVar

from drillrig_env.command_line import Failed, deaf_to_interrupt
from drillrig_env.engine.contract import Engine, Outcome, innermost, wait_for

if TYPE_CHECKING:
    from concurrent.futures import Future, ProcessPoolExecutor

P = TypeVar("P")
R = TypeVar("R")

_AHEAD = 2  # pieces that a process is given beyond the one that it does, so that it need not wait


class Local(Engine):
    """The machine itself: with `jobs` = 1 one piece after another in this process, whose kernels have all the cores.

    With more, and for pieces that are apart, processes are spawned, which end with the block: a script that has them
    must do its work below `if __name__ == "__main__"`. They do not hear Ctrl-C; where it comes they are ended.
    """

    where = "local"

    def __init__(self, jobs: int = 1) -> None:
        super().__init__(jobs)
        self.side_by_side = jobs
        self.here = jobs == 1
        self._pool: _Processes | None = None
        self._folder: Path | None = None
        self._known: tuple[Any, Path] | None = None
        self._sent = 0

    def outcomes(
        self,
        work: Callable[[P], R],
        pieces: Iterable[P],
        *,
        apart: bool = False,
        meanwhile: Callable[[], object] | None = None,
    ) -> Iterator[Outcome[R]]:
        """As in `Engine`."""
        alone = self.here or (isinstance(pieces, Sized) and len(pieces) < 2)
        if alone and not apart:
            yield from _here(work, pieces)
        elif apart:
            yield from self._apart(work, pieces, meanwhile)
        else:
            yield from self._shared(work, pieces, meanwhile)

    def end(self) -> None:
        """End the processes, whatever they do."""
        if self._pool is not None:
            self._pool.kill()
            self._pool = None
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = self._known = None

    def _shared(
        self, work: Callable[[P], R], pieces: Iterable[P], meanwhile: Callable[[], object] | None
    ) -> Iterator[Outcome[R]]:
        """By processes that do one piece after another, and stay for other work."""
        path = self._written(work)
        self._pool = pool = self._pool or _Processes(self.side_by_side)
        numbers: dict[Future[Any], int] = {}
        waiting = enumerate(pieces)
        try:
            while True:
                for number, piece in self._next(waiting, self.side_by_side * _AHEAD - len(numbers)):
                    numbers[pool.submit(path, piece)] = number
                if not numbers:
                    return
                for future in _ended(numbers, meanwhile):
                    outcome = _outcome(numbers.pop(future), future, self.side_by_side)
                    if isinstance(outcome.error, _Killed):  # which has broken the pool
                        raise outcome.error
                    yield outcome
        except BaseException:
            self.end()
            raise

    def _apart(
        self, work: Callable[[P], R], pieces: Iterable[P], meanwhile: Callable[[], object] | None
    ) -> Iterator[Outcome[R]]:
        """By a process for each piece, so that one that is killed takes none with it."""
        from drillrig_env.engine.worker import LEAVE

        path = self._written(work)
        running: dict[Future[Any], tuple[int, _Processes]] = {}
        waiting = enumerate(pieces)

        def ended(within: float | None = None) -> Iterator[Outcome[R]]:
            for future in _ended(running, meanwhile, within):
                number, pool = running.pop(future)
                pool.leave()
                yield _outcome(number, future, self.side_by_side)

        try:
            while True:
                for number, piece in self._next(waiting, self.side_by_side - len(running)):
                    pool = _Processes(1, apart=True)
                    running[pool.submit(path, piece)] = number, pool
                if not running:
                    return
                yield from ended()
        except (KeyboardInterrupt, GeneratorExit) as stop:
            for _, pool in running.values():
                pool.stop()
            while running and (last := list(ended(LEAVE))):
                if isinstance(stop, KeyboardInterrupt):
                    yield from last
            raise
        finally:
            for _, pool in running.values():
                pool.kill()

    def _written(self, work: Any) -> Path:
        """The file with the work, for as long as it is the last."""
        from drillrig_env.engine.worker import packed_work  # loaded by those alone who have processes

        if self._known is None or self._known[0] is not work:
            if self._folder is None:
                self._folder = Path(mkdtemp(prefix="drillrig-"))
            if self._known is not None:
                self._known[1].unlink(missing_ok=True)
            self._sent += 1
            path = self._folder / f"work_{self._sent}"
            path.write_bytes(packed_work(work))
            self._known = work, path
        return self._known[1]


class _Killed(Failed):
    """A process has ended in the midst of a piece."""


class _Processes:
    """A pool of spawned processes."""

    def __init__(self, count: int, apart: bool = False) -> None:
        from concurrent.futures import ProcessPoolExecutor
        from multiprocessing import get_context

        from drillrig_env.engine.worker import begin

        context = get_context("spawn")
        self._there, self._here = context.Pipe(duplex=False)
        self._pool: ProcessPoolExecutor = ProcessPoolExecutor(count, context, begin, (self._there, apart))

    def submit(self, path: Path, piece: Any) -> Future[Any]:
        from drillrig_env.engine.packing import packed
        from drillrig_env.engine.worker import answer_from_file

        with deaf_to_interrupt():  # a process may be started for it
            return self._pool.submit(answer_from_file, path, packed(piece))

    def stop(self) -> None:
        """Ask pieces that are apart to come to their end, and end other processes."""
        self._here.close()

    def leave(self) -> None:
        """Wait for processes that have nothing left to do."""
        self._pool.shutdown()
        self._there.close()
        self._here.close()

    def kill(self) -> None:
        """End the processes, whatever they do."""
        processes = list((self._pool._processes or {}).values())
        self._pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.kill()
        self.leave()


def _here(work: Callable[[P], R], pieces: Iterable[P]) -> Iterator[Outcome[R]]:
    for number, piece in enumerate(pieces):
        try:
            outcome = Outcome(number, work(piece))
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a stranger's policy may raise anything
            outcome = Outcome(number, error=error, calls=innermost(error))
        yield outcome


def _ended(
    futures: Iterable[Future[Any]], meanwhile: Callable[[], object] | None, within: float | None = None
) -> list[Future[Any]]:
    """Futures that have ended, at least one of them, or none `within` s."""
    from concurrent.futures import FIRST_COMPLETED, wait

    asked = list(futures)

    def look(seconds: float) -> list[Future[Any]]:
        done, _ = wait(asked, seconds, FIRST_COMPLETED)
        return [future for future in asked if future in done]

    return wait_for(look, meanwhile, within)


def _outcome(number: int, future: Future[Any], jobs: int) -> Outcome[Any]:
    from concurrent.futures.process import BrokenProcessPool

    from drillrig_env.engine.worker import opened

    try:
        return opened(number, future.result())
    except BrokenProcessPool:
        return Outcome(
            number,
            error=_Killed(
                f"one of {jobs} processes ended in the midst of its work; give it more memory or fewer jobs, and have "
                'a script that starts them below if __name__ == "__main__"'
            ),
        )
