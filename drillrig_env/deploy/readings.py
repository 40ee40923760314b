"""What a rig has sent last, and how old that is by one's own clock."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_HALF = 2.5  # s


class Readings:
    """The latest message of measurements of the rig at `address`; those that were overtaken underway are passed over.

    A message has `time` (s of the rig's), `values` by channel, `reference` (rad/s) and `state`, and may have `ages`
    (s). `same_clock` tells that this side goes by the rig's own clock. Otherwise the fastest message of the last
    seconds tells how far the clocks are apart, and what is later than that is old; so a clock that jumped is got over.
    """

    def __init__(self, address: str, same_clock: bool = False) -> None:
        self.address = address
        self.fresh = False
        self.values: Mapping[str, Any] = {}
        self.reference = 0.0
        self.armed_at: float | None = None
        self._ages: Mapping[str, float] = {}
        self._time = float("-inf")
        self._same = same_clock
        self._since = float("-inf")  # of the newer half of those seconds
        self._offsets = (0.0, 0.0) if same_clock else (float("inf"), float("inf"))  # of the older and the newer half

    def take(self, message: Mapping[str, Any], clock: float) -> None:
        """Take in a message that came at a time (s) of the own clock.

        `ConnectionError` where the rig's watchdog has taken over since `armed_at`; `KeyError`, `TypeError` or
        `ValueError` for what is no such message.
        """
        time, values, state = float(message["time"]), message["values"], message["state"]
        reference, ages = float(message["reference"]), dict(message.get("ages", {}))
        if not isinstance(values, Mapping):
            raise TypeError("values are no object")
        if not self._same:
            older, newer = self._offsets
            if clock - self._since > _HALF:
                older, newer, self._since = newer, float("inf"), clock
            self._offsets = older, min(newer, clock - time)
        if time <= self._time:
            return
        self._time, self.values, self.reference, self._ages, self.fresh = time, values, reference, ages, True
        if self.armed_at is not None and time > self.armed_at and state == "tripped":
            raise ConnectionError(f"the watchdog of {self.address} has taken over; it waits to be armed again")

    def seen(self) -> Mapping[str, Any]:
        """The latest values, which are no news from now on. `ConnectionError` where none have ever come."""
        if not self.values:
            raise ConnectionError(f"{self.address} sends no measurements")
        self.fresh = False
        return self.values

    def ages(self, clock: float) -> dict[str, float]:
        """How old (s) the values are at a time (s) of the own clock, by channel."""
        underway = max(0.0, clock - min(self._offsets) - self._time)
        return {name: underway + self._ages.get(name, 0.0) for name in self.values}
