"""What is to be sent to one client: never more than a few seconds of it, however slow the client is."""

from __future__ import annotations

import asyncio
from collections import deque

from drillrig_env.room.lanes import Step

MOST_STEPS = 64
"""Control steps that wait for a client, at most; older ones are left out, and the client is told of the gap."""

_MOST_TEXTS = 64


class Outbox:
    """Steps and texts for one client. Of texts of one kind that tell how things are, only the newest waits."""

    def __init__(self) -> None:
        self._steps: deque[Step] = deque()
        self._texts: dict[object, str] = {}
        self._gap, self._count = False, 0
        self._filled = asyncio.Event()
        self.left_out = 0  # control steps in all

    def add(self, step: Step, more: bool = False) -> None:
        """Put a control step in; where too many wait, the oldest one is left out.

        Where `more` come at once, it waits for them, to go in one frame.
        """
        if len(self._steps) == MOST_STEPS:
            self._steps.popleft()
            self._gap, self.left_out = True, self.left_out + 1
        self._steps.append(step)
        if not more:
            self._filled.set()

    def say(self, text: str, kind: str = "") -> None:
        """Put a text in; it takes the place of one of the same `kind` that still waits."""
        self._count += 1
        key: object = kind or self._count
        self._texts.pop(key, None)
        self._texts[key] = text
        while len(self._texts) > _MOST_TEXTS:
            del self._texts[next(iter(self._texts))]
        self._filled.set()

    def forget_steps(self) -> None:
        """Leave out the steps that wait: they are of a run that is over."""
        self._steps.clear()
        self._gap = False

    async def take(self) -> tuple[list[str], list[Step], bool]:
        """Wait for something, and take all of it: texts, steps, and whether steps before these were left out."""
        await self._filled.wait()
        self._filled.clear()
        texts, steps, gap = list(self._texts.values()), list(self._steps), self._gap
        self._texts.clear()
        self.forget_steps()
        return texts, steps, gap
