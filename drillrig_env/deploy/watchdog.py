"""The rig's side of the line: what becomes of the speed reference when commands no longer come."""

from __future__ import annotations

from math import isfinite

from drillrig_env.deploy.checks import last_number
from drillrig_env.deploy.events import Events
from drillrig_env.parameters import COUNT, NOT_NEGATIVE, POSITIVE, checked

_SHOWN = 40  # characters of a command that is refused


class Watchdog:
    """Holds the last command, and takes over when none has come for `periods` control periods of `period` s.

    `events` keeps what it does, a new one if None.

    It belongs into the program that talks to the drive, apart from the one that runs the policy. Taking over it ramps
    the reference to `fallback_speed` (rad/s), or leaves it where it is below, at `ramp` (rad/s^2), and refuses all
    commands until it is armed again. A command that is not finite or not within 0 to `highest` (rad/s) is refused and
    counts as none. All times are those of one clock that never runs backwards, in s.
    """

    def __init__(
        self,
        period: float,
        fallback_speed: float,
        highest: float,
        periods: int = 3,
        ramp: float = 0.5,
        events: Events | None = None,
    ) -> None:
        self.period = checked("Watchdog", "period", period, "s", POSITIVE)
        self.fallback_speed = checked("Watchdog", "fallback_speed", fallback_speed, "rad/s", NOT_NEGATIVE)
        self.highest = checked("Watchdog", "highest", highest, "rad/s", POSITIVE)
        self.periods = checked("Watchdog", "periods", periods, "", COUNT)
        self.ramp = checked("Watchdog", "ramp", ramp, "rad/s^2", POSITIVE)
        self.events = Events() if events is None else events
        self.tripped = True  # until it is armed
        self._bottom = self.fallback_speed
        self._refuses = False
        self._reference = self._came = self._asked = 0.0

    def arm(self, reference: float, time: float) -> None:
        """Begin, or begin again, at the speed reference (rad/s) that the drive has now. `time` is now, s."""
        self._reference = checked("Watchdog", "reference", reference, "rad/s", NOT_NEGATIVE)
        self._came = self._asked = time
        self.tripped = False
        self.events.add(time, "armed", "armed", f"at {reference:g} rad/s")

    def release(self, time: float) -> None:
        """End in order: the reference stays as it is, and no command is taken until it is armed again.

        `time` is now, s.
        """
        self._look(time)
        if not self.tripped:
            self.tripped, self._bottom = True, self._reference
            self.events.add(time, "released", "released", f"at {self._reference:g} rad/s")

    def command(self, reference: float, time: float) -> bool:
        """Take a command; whether it is taken. `reference` is in rad/s, `time` is when it came, s."""
        self._look(time)
        found = last_number(reference) if isinstance(reference, float | int) else None
        number = float("nan") if found is None else found
        if self.tripped:
            return False
        if not (isfinite(number) and 0.0 <= number <= self.highest):
            if not self._refuses:  # the first of several
                reason = f"command {ascii(reference)[:_SHOWN]}; allowed: 0 to {self.highest:g} rad/s"
                self.events.add(time, "armed", "refused", reason)
            self._refuses = True
            return False
        self._refuses = False
        self._reference, self._came = float(number), time
        return True

    def reference(self, time: float) -> float:
        """The speed reference (rad/s) for the drive now; to be asked for at every cycle of the drive's program.

        `time` is now, s.
        """
        self._look(time)
        passed, self._asked = time - self._asked, time
        if self.tripped and self._reference > self._bottom:
            self._reference = max(self._reference - self.ramp * passed, self._bottom)
        return self._reference

    def _look(self, time: float) -> None:
        silent = time - self._came
        if not self.tripped and silent > self.periods * self.period * (1.0 + 1e-9):
            self.tripped, self._bottom = True, self.fallback_speed
            self._asked = self._came + self.periods * self.period
            reason = f"no command for {silent:.3g} s, over {self.periods} periods; to {self.fallback_speed:g} rad/s"
            self.events.add(time, "tripped", "watchdog", reason)
