"""What happened and why: every change of state, every limit that was met, every fault, in the order of time."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Event:
    """One thing that happened at a `time` (s), in a `state`: of which `kind`, and the `reason` in words.

    >>> print(Event(12.3, "normal", "limit", "the rate of the speed reference"))
    12.300 s, normal: limit: the rate of the speed reference
    """

    time: float
    state: str
    kind: str
    reason: str

    def __str__(self) -> str:
        return f"{self.time:.3f} s, {self.state}: {self.kind}: {self.reason}"


class Events:
    """The events so far; with `path` each is also written there, a line each, at once, as long as that can be done.

    >>> events = Events()
    >>> events.add(12.3, "normal", "limit", "the rate of the speed reference is limited")
    >>> print(events.of("limit")[0])
    12.300 s, normal: limit: the rate of the speed reference is limited
    """

    def __init__(self, path: str | Path | None = None) -> None:
        self.path = None if path is None else Path(path)
        self.kept: list[Event] = []

    def add(self, time: float, state: str, kind: str, reason: str) -> None:
        """Keep an event.

        `time` (s) is when it happened, `state` that of the supervisor, `kind` its word, and `reason` says why.
        """
        event = Event(time, state, kind, reason)
        self.kept.append(event)
        if self.path is not None:
            with suppress(OSError), self.path.open("a", encoding="utf-8") as file:
                file.write(f"{event}\n")

    def of(self, kind: str) -> list[Event]:
        """The events of a kind."""
        return [event for event in self.kept if event.kind == kind]
