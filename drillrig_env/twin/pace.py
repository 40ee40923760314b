"""At which speed the rig's time runs: some times the system's, or only as far as a client asks."""

from __future__ import annotations

import asyncio
import time as system
from collections.abc import Callable
from typing import Any

from drillrig_env.parameters import refuse
from drillrig_env.twin.station import Station

_ROUNDING = 1e-6  # of a part
_FURTHEST = 60.0  # s of the rig's time, that a client may ask for at once
_CAUGHT_UP = 0.1  # s of the system's time that a rig which waits may make up for
_LONGEST_ARREARS = 1.0  # s of the system's time, beyond which the rig does not catch up: the computer was asleep


class Pace:
    """Lets a station's time run `speed` times as fast as the system's; with `waits` only up to `until`.

    Each of `receivers` is given every message that has arrived.
    """

    def __init__(self, station: Station, speed: float = 1.0, waits: bool = False) -> None:
        self.station, self.speed, self.waits = station, speed, waits
        self.receivers: list[Callable[[dict[str, Any]], None]] = []
        self._one = asyncio.Lock()
        self._until, self._first = 0.0, False
        self._asked, self._reached = asyncio.Event(), asyncio.Event()

    async def ask(self, until: float, first: bool) -> float:
        """Let the time of a rig that waits run until a time (s), or to the `first` message; the time it is then.

        Of several clients each waits for its turn. `ValueError` where it does not wait, or the time is none or far off.
        """
        if not self.waits:
            raise ValueError("until is not allowed: the time of this rig does not wait")
        async with self._one:
            ahead = until - self.station.time
            if not ahead <= _FURTHEST:
                raise refuse("until", "until", until, "s", f"a time up to {_FURTHEST:g} s from now")
            self._until, self._first = until, first
            self._reached.clear()
            self._asked.set()
            await self._reached.wait()
            return self.station.time

    async def run(self) -> None:
        """Let the time run until the station's rig is over."""
        part = self.station.rig.part
        due = system.perf_counter()
        while not self.station.rig.is_over:
            if self.waits:
                await self._wait()
                due = max(due, system.perf_counter() - _CAUGHT_UP)
            due += part / self.speed
            ahead = due - system.perf_counter()
            if -ahead > _LONGEST_ARREARS:
                due -= ahead
            await asyncio.sleep(max(ahead, 0.0))
            messages = self.station.advance()
            for message in messages:
                for receive in self.receivers:
                    receive(message)
            if messages and self._first:
                self._until = self.station.time

    async def _wait(self) -> None:
        """Stand still until more time is asked for."""
        while self.station.time >= self._until - _ROUNDING * self.station.rig.part:
            self._reached.set()
            await self._asked.wait()
            self._asked.clear()
