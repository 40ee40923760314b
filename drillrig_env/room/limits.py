"""What one client may ask of the server, and how many clients there may be."""

from __future__ import annotations

import time
from dataclasses import dataclass

from drillrig_env.parameters import COUNT, POSITIVE, check_fields, parameter


@dataclass(frozen=True)
class Limits:
    """Limits of the room. Raises `ValueError` for one that is not allowed."""

    clients: int = parameter(8, meaning="clients at once", allowed=COUNT)
    message_bytes: int = parameter(16_384, "bytes", "longest message but for a run to replay", allowed=COUNT)
    run_bytes: int = parameter(4_194_304, "bytes", "longest message with a run to replay", allowed=COUNT)
    messages: float = parameter(60.0, "1/s", "messages that a client may send for long", allowed=POSITIVE)
    burst: int = parameter(240, meaning="messages that it may send at once", allowed=COUNT)
    mistakes: int = parameter(20, meaning="messages that are none, until the client is sent away", allowed=COUNT)
    first: float = parameter(10.0, "s", "until the first message must have come", allowed=POSITIVE)
    idle: float = parameter(300.0, "s", "without any message, until the client is sent away", allowed=POSITIVE)

    def __post_init__(self) -> None:
        check_fields(self)


class Bucket:
    """Counts what comes: `burst` at once, and `rate` (1/s) for long."""

    def __init__(self, rate: float, burst: int) -> None:
        self._rate, self._burst = rate, float(burst)
        self._left, self._since = float(burst), time.monotonic()

    def take(self) -> bool:
        """Count one; whether it is within the limit."""
        now = time.monotonic()
        self._left = min(self._left + (now - self._since) * self._rate, self._burst)
        self._since = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
