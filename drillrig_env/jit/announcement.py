"""One line on the terminal when a compilation takes so long that somebody may wonder."""

from __future__ import annotations

import sys
from threading import Timer
from typing import Any

from numba.core import event

_PATIENCE = 1.0
"""Seconds of compilation after which a line is printed."""

_listener: Any = event.Listener  # its type says nothing of what it does


class Announcement(_listener):  # type: ignore[misc]
    """Says once a process that kernels of a package are being compiled, if that takes long; a cache says nothing."""

    def __init__(self, package: str) -> None:
        self.package = package
        self.said = False
        self._depth = 0
        self._timer: Timer | None = None

    def on_start(self, event: Any) -> None:
        """A compilation begins, perhaps within another one."""
        module = event.data["dispatcher"].py_func.__module__ or ""  # what `exec` makes has none
        if self.said or (self._depth == 0 and module.partition(".")[0] != self.package):
            return
        self._depth += 1
        if self._depth == 1:
            self._timer = Timer(_PATIENCE, self._say)
            self._timer.daemon = True
            self._timer.start()

    def on_end(self, event: Any) -> None:
        """It is done."""
        self._depth = max(self._depth - 1, 0)
        if self._depth == 0 and self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _say(self) -> None:
        self.said = True
        print("drillrig: compiling the kernels, once (about 5 s)", file=sys.stderr, flush=True)


def announce_compilation(package: str) -> None:
    """From now on, say once when kernels of `package` take long to compile."""
    register: Any = event.register
    register("numba:compile", Announcement(package))
