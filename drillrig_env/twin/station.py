"""The rig's side of the line: the drive and its watchdog, who may command it, and the channels to and from them.

Nobody commands at first: the drive keeps its speed reference. One client at a time may have the rig; where its commands
no longer come, the watchdog takes over, and the next one may have the rig.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from drillrig_env.deploy.events import Events
from drillrig_env.deploy.watchdog import Watchdog
from drillrig_env.twin.channel import Channel, Wire
from drillrig_env.twin.faults import Fault, FaultyInstruments
from drillrig_env.twin.rig import PARTS, SimulatedRig

IDLE, ARMED, TRIPPED = "idle", "armed", "tripped"
"""States: nobody commands; a client does; its commands did not come, and the watchdog has the drive."""

_MOST_COMMANDS = 100  # underway at a time
_FALLBACK_SPEED, _RAMP = 1.0, 0.5  # of the watchdog on the chapter's rig, rad/s and rad/s^2


class Station:
    """A rig with its drive. `wire` says what becomes of measurements and commands underway, by `seed`.

    `periods` is how many silent control periods the watchdog bears. All times are the rig's, in s.
    """

    def __init__(
        self,
        rig: SimulatedRig,
        wire: Wire | None = None,
        faults: Sequence[Fault] = (),
        periods: int = 3,
        seed: int = 0,
        events: Events | None = None,
    ) -> None:
        self.rig = rig
        self.events = Events() if events is None else events
        scales, highest = rig.usual.scales, rig.usual.largest_reference
        self.watchdog = Watchdog(
            rig.period,
            fallback_speed=_FALLBACK_SPEED * scales.speed,
            highest=highest,
            periods=periods,
            ramp=_RAMP * scales.rate,
            events=self.events,
        )
        self.instruments = FaultyInstruments(faults, tuple(rig.channels), rig.period)
        to, fro = np.random.SeedSequence(seed).spawn(2)
        self._measurements = Channel(wire or Wire(), np.random.default_rng(to))
        self._commands = Channel(wire or Wire(), np.random.default_rng(fro))
        self.owner: object = None
        self.taken = 0
        self._parts = 0

    @property
    def time(self) -> float:
        """The rig's time, s."""
        return self.rig.time

    @property
    def state(self) -> str:
        """Who has the drive: `IDLE`, `ARMED` or `TRIPPED`."""
        return IDLE if self.owner is None else TRIPPED if self.watchdog.tripped else ARMED

    def arm(self, client: object) -> None:
        """Let a client have the rig. `ValueError` where another has it."""
        if self.state == ARMED and self.owner is not client:
            raise ValueError("another client has the rig; allowed: once it has given it back, or its watchdog has it")
        self.owner, self.taken = client, 0
        self._commands.arrived(float("inf"))  # what is still underway was another's
        self.watchdog.arm(self.rig.reference, self.time)

    def release(self, client: object) -> None:
        """Take the rig back from the client that has it: the drive keeps its reference."""
        if self.owner is client and self.state == ARMED:
            self.owner = None
            self.watchdog.release(self.time)

    def command(self, client: object, reference: float) -> None:
        """Put a client's speed reference (rad/s) on its way to the drive. `ValueError` where it has not the rig."""
        if self.owner is not client:
            raise ValueError("command without the rig; arm first")
        if self._commands.waiting >= _MOST_COMMANDS:
            raise ValueError(f"{_MOST_COMMANDS} commands are underway already; allowed: one a control period")
        self._commands.send(reference, self.time)

    def message(self, time: float) -> dict[str, Any]:
        """The measurements of now, as they leave the rig."""
        values, ages = self.instruments.show(self.rig.measure(), time)
        shown = {"time": time, "values": values, "reference": self.rig.reference, "state": self.state}
        return {**shown, "taken": self.taken, **({"ages": ages} if ages else {})}

    def advance(self) -> list[dict[str, Any]]:
        """Let a part of a control period pass; the messages that arrive at its end."""
        now = self.time
        for reference in self._commands.arrived(now):
            self.taken += self.watchdog.command(reference, now)
        if self.owner is not None:
            self.rig.reference = self.watchdog.reference(now)
        self.rig.advance()
        self._parts += 1
        if self._parts % PARTS == 0:
            self._measurements.send(self.message(self.time), self.time)
        return self._measurements.arrived(self.time)
