"""How far a search is: a bar in a terminal, and elsewhere a line at most every half minute."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Self

from drillrig_env.progress import Progress

_PARTS = 1000
_SECONDS = 30.0  # between two lines where the output is no terminal


class Shown:
    """Tells of the tries of a search on standard error, where `progress` asks for it."""

    def __init__(self, progress: bool = True) -> None:
        self._bar = Progress("tuning", 1) if progress and sys.stderr.isatty() else None
        self._lines, self._told = progress and self._bar is None, -_SECONDS

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.__exit__(kind, error, trace)

    def tell(self, number: int, how: str, share: float) -> None:
        """Of the try of this number: how it does, in words; a `share` of the budget is spent."""
        if self._bar is not None:  # which is not to say that it is done before it is
            self._bar.show(f"try {number}", min(int(_PARTS * share), _PARTS - 1), _PARTS, f" {how}")
        elif self._lines and time.monotonic() - self._told > _SECONDS:
            self._told = time.monotonic()
            print(f"try {number} {how}; {share:.0%} of the budget is spent", file=sys.stderr, flush=True)
