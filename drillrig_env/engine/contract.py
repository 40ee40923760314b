"""The one contract of every engine: do these pieces of work, in any order, and hand over each as it is done."""

from __future__ import annotations

import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Generic, Self, TypeVar

from drillrig_env.allowed import COUNT
from drillrig_env.parameters import checked

P = TypeVar("P")
R = TypeVar("R")


_LOOK = 0.2  # s between two calls of `meanwhile`

CALLS = 3
"""Calls of an error's traceback that are told, the innermost."""


def innermost(error: BaseException) -> str:
    """The innermost calls of an error's traceback, as text."""
    return "".join(traceback.format_tb(error.__traceback__)[-CALLS:]).rstrip()


def wait_for(look: Callable[[float], list[R]], meanwhile: Callable[[], object] | None, within: float | None) -> list[R]:
    """What `look`, which waits up to the seconds that it is given, has found to be done: something, or none `within` s.

    `meanwhile` is called each time that it has looked.
    """
    waited = 0.0
    while True:
        done = look(_LOOK)
        waited += _LOOK
        if meanwhile is not None:
            meanwhile()
        if done or (within is not None and waited > within):
            return done


@dataclass(frozen=True)
class Outcome(Generic[R]):
    """What came of the piece of this number: its result, or the error that it raised with the innermost calls of it.

    `processor` is the type of the processor that did it, empty where it is this machine's.
    """

    number: int
    result: R | None = None
    error: BaseException | None = None
    calls: str = ""
    processor: str = ""

    def value(self) -> R:
        """The result; what the piece raised is raised here."""
        if self.error is not None:
            raise self.error
        return self.result  # type: ignore[return-value]  # where there is no error there is a result


class Engine(ABC):
    """Does pieces of work, up to `jobs` at a time (None: as many as there is room for), and ends with its block.

    `where` is what `--on` calls it. `here` says whether pieces are done one after another in this very process, where
    they may tell how far they are. `processors` are the types of the processors that have done pieces elsewhere.
    """

    where: str
    here: bool = False

    def __init__(self, jobs: int | None = None) -> None:
        self.jobs = None if jobs is None else int(checked("engine", "jobs", jobs, "", COUNT))
        self.processors: set[str] = set()

    @abstractmethod
    def outcomes(
        self,
        work: Callable[[P], R],
        pieces: Iterable[P],
        *,
        apart: bool = False,
        meanwhile: Callable[[], object] | None = None,
    ) -> Iterator[Outcome[R]]:
        """What `work` makes of each piece, in the order in which they are done.

        Pieces are taken from the iterable when there is room for more. What a piece raises is its outcome, and the
        others go on; `Failed` is that of one whose process was killed again and again. A piece that is `apart` has a
        process of its own, in which `stop_asked` (`drillrig_env.engine.worker`) tells when it should come to its end.
        `meanwhile` is called several times a second where pieces are done elsewhere.

        Ctrl-C, and leaving the loop, cancel what has not been done; pieces that are apart may come to their end first,
        within 4 s.
        """

    def each(self, work: Callable[[P], R], pieces: Iterable[P]) -> Iterator[tuple[int, R]]:
        """The number of each piece and what `work` makes of it, as they are done. What it raises comes out here."""
        for outcome in self.outcomes(work, pieces):
            yield outcome.number, outcome.value()

    def map(self, work: Callable[[P], R], pieces: Iterable[P]) -> list[R]:
        """What `work` makes of each piece, in the order of the pieces."""
        return [result for _, result in sorted(self.each(work, pieces), key=lambda one: one[0])]

    def end(self) -> None:  # noqa: B027  # an engine may have nothing to end
        """End what was started for the pieces."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()

    @staticmethod
    def _next(waiting: Iterator[tuple[int, P]], count: int) -> Iterator[tuple[int, P]]:
        """The next `count` of what waits, or as many as there are, without a look at those after them."""
        for _ in range(count):
            try:
                yield next(waiting)
            except StopIteration:
                return

    def _seen(self, outcome: Outcome[Any]) -> Outcome[Any]:
        """An outcome that has come from elsewhere, whose processor is noted."""
        if outcome.processor:
            self.processors.add(outcome.processor)
        return outcome
