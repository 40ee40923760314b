"""How far long work is: a bar in a terminal, and a line for each part that is done where there is none."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any, Self, TextIO


class Progress:
    """Parts of some work, one after another, on standard error: what goes on, how far it is, and what is done.

    In a terminal it is one line that changes, never wider than the terminal, and gone at the end. Elsewhere,
    or without `rich`, it is a line a part.

    >>> with Progress("default", parts=2) as progress:
    ...     for policy in ("constant", "lqg"):
    ...         for step in range(600):
    ...             progress.show(policy, step + 1, 600)
    """

    def __init__(self, title: str, parts: int, file: TextIO | None = None) -> None:
        self.title, self.parts = title, parts
        self._file = file or sys.stderr
        self._bar = _bar(self._file) if self._file.isatty() else None
        self._task: Any = None
        self._begun, self._done = dict[str, float](), 0

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
            self._task = self._bar.add_task(self.title)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def show(self, part: str, done: int, of: int, note: str = "") -> None:
        """Of the part of this name `done` steps of `of` are done; a `note` of how it goes stands behind it."""
        begun = self._begun.setdefault(part, time.monotonic())
        if done == of:
            self._done += 1
        if self._bar is not None:
            self._bar.update(self._task, description=f"{self.title}: {part}{note}", completed=done, total=of)
        elif done == of:
            spent = time.monotonic() - begun
            print(f"{self.title}: {part} done in {spent:.1f} s ({self._done} of {self.parts}){note}", file=self._file)
            self._file.flush()


def _bar(file: TextIO) -> Any:
    """A bar whose columns are cut, not wrapped, where the terminal is narrow; None without `rich`."""
    try:
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bars
        from rich.table import Column
    except ImportError:
        return None

    def column() -> Column:
        return Column(no_wrap=True, overflow="ellipsis")

    columns = (
        TextColumn("{task.description}", table_column=column()),
        BarColumn(20, table_column=column()),
        TimeRemainingColumn(compact=True, table_column=column()),
    )
    return Bars(*columns, console=Console(file=file), transient=True)
