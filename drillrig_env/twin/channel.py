"""A channel of messages that loses some of them and is late with others, by a seed, in the rig's own time."""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from drillrig_env.allowed import Allowed
from drillrig_env.parameters import NOT_NEGATIVE, check_fields, parameter

_ROUNDING = 1e-9  # s


@dataclass(frozen=True)
class Wire:
    """What becomes of messages underway, either way. Raises `ValueError` for a value that is not allowed."""

    loss: float = parameter(0.0, meaning="share of the messages that are lost", allowed=Allowed(0.0, 1.0))
    latency: float = parameter(0.0, "s", "by which every message is late", allowed=NOT_NEGATIVE)
    jitter: float = parameter(0.0, "s", "by up to which it is later, drawn for each", allowed=NOT_NEGATIVE)

    def __post_init__(self) -> None:
        check_fields(self)


Waiting: TypeAlias = tuple[float, int, Any]


@dataclass
class Channel:
    """One way through a `wire`; messages may overtake each other. Times are the rig's, s."""

    wire: Wire
    generator: np.random.Generator
    _waiting: list[Waiting] = field(default_factory=list)
    _sent: int = 0

    def send(self, message: Any, time: float) -> None:
        """Put a message on its way, or lose it."""
        late = self.wire.latency + self.wire.jitter * self.generator.random()
        lost = self.generator.random() < self.wire.loss
        self._sent += 1
        if not lost:
            heapq.heappush(self._waiting, (time + late, self._sent, message))

    @property
    def waiting(self) -> int:
        """How many messages are underway."""
        return len(self._waiting)

    def arrived(self, time: float) -> list[Any]:
        """The messages that have come by a time, in the order in which they came."""
        found = []
        while self._waiting and self._waiting[0][0] <= time + _ROUNDING:
            found.append(heapq.heappop(self._waiting)[2])
        return found
