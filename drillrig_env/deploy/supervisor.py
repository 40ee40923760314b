"""A controller under supervision: limits, trusted measurements, a fallback, a ramp down, an operator's stop.

| state | the speed reference | left |
|---|---|---|
| NORMAL | the policy's, within the limits | for HOLD at a fault; for RAMP at an overload or a stop |
| HOLD | is held | for NORMAL after `sound_time` without a fault; for FALLBACK after `hold_time` |
| FALLBACK | that of a simple law, within the limits | for NORMAL likewise; for RAMP after `fallback_time` |
| RAMP | goes down at `ramp`, to `safe_speed` or to what the operator asked for | for STOPPED when it is there |
| STOPPED | stays there | by `restart` alone, as RAMP |

A fault is a measurement that is missing, stale, frozen or implausible, a control step that came late or early, or a
policy that failed. An overload is a top speed above its limit, or current or torque above theirs for `overload_time`.
All depends on what `step` is given and on nothing else, so that a log can be replayed to the last bit.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Any

from drillrig_env.deploy.checks import Checks, last_number
from drillrig_env.deploy.controller import TARGET, Controller
from drillrig_env.deploy.events import Events
from drillrig_env.deploy.fallback import Fallback
from drillrig_env.deploy.limits import Limits
from drillrig_env.deploy.overload import Overload
from drillrig_env.parameters import refuse

_ROUNDING = 1e-9  # s
_EARLY, _LATE = 0.5, 3.0  # control periods between two steps, below and above which a step counts as a fault
_CLIPPED = 10.0  # scales of a channel beside its offset, where the policy sees no further


class State(StrEnum):
    """What a supervisor does."""

    NORMAL = "normal"
    HOLD = "hold"
    FALLBACK = "fallback"
    RAMP = "ramp"
    STOPPED = "stopped"


class Supervisor:
    """A `Controller`, or a policy by name or file, that acts within `limits` and stands back in a fault.

    `events` keeps what it does, a new one if None.

    Without `limits` they are those of the rig that the policy is for.

    Values are those of the controller's units, and must be SI: a controller with other `units` is refused.
    """

    def __init__(self, policy: Any, limits: Limits | None = None, events: Events | None = None) -> None:
        self.controller = policy if isinstance(policy, Controller) else Controller(policy)
        if self.controller.units:
            raise refuse("Supervisor", "units of the controller", self.controller.units, "", "none: SI units")
        self.limits = Limits.for_policy(self.controller.file.about) if limits is None else limits
        self.events = Events() if events is None else events
        self.fallback = Fallback(self.limits.fallback, self.controller)
        self.channels = tuple(dict.fromkeys((*self.controller.channels, *self.fallback.channels)))
        self._faults: Mapping[str, str] = {}
        self._checks = Checks(self.limits, self._ranges())
        self.state = State.STOPPED
        self.reference = 0.0
        self._time: float | None = None
        self._since = self._sound = 0.0
        self._bottom = self.limits.safe_speed
        self._clipped = self._begins_anew = False
        self._overload = Overload(self.limits)

    def start(self, reference: float, target: float, measurements: Mapping[str, Any], time: float = 0.0) -> None:
        """Begin at a time (s) from the speed reference as it is (rad/s). `ValueError` as for `Controller.start`.

        `target` is in rad/s, `measurements` are values by channel.
        """
        self.controller.start(reference, target, measurements)
        self._checks = Checks(self.limits, self._ranges())
        self.reference, self._time = float(reference), float(time)
        self._overload, self._faults = Overload(self.limits), {}
        self._enter(State.NORMAL, "start", f"from {reference:g} to {target:g} rad/s")

    @property
    def target(self) -> float:
        """What the operator wants, rad/s."""
        return self.controller.target

    @target.setter
    def target(self, target: float) -> None:
        if target != self.controller.target:
            self.controller.target = target
            self._tell("target", f"{target:g} rad/s")

    def stop(self, reason: str = "operator", speed: float = 0.0) -> None:
        """Ramp down to a speed (rad/s) and stay there, whatever the policy wants. `reason` is kept with the event."""
        if not 0.0 <= speed <= self.limits.highest_reference:
            raise refuse("stop", "speed", speed, "rad/s", f"0 to {self.limits.highest_reference:g}")
        self._bottom = min(speed, max(self.reference, 0.0))
        self._enter(State.RAMP, "stop", reason)

    def restart(self, measurements: Mapping[str, Any]) -> None:
        """Let the policy act again, from the reference as it is. `ValueError` where the last step found a fault.

        `measurements` are values by channel.
        """
        if self._faults:
            raise ValueError(f"restart is not allowed: {_words(self._faults)}")
        self.controller.start(self.reference, self.target, self._read(measurements))
        self._overload, self._bottom = Overload(self.limits), self.limits.safe_speed
        self._enter(State.NORMAL, "restart", f"from {self.reference:g} rad/s")

    def tell(self, kind: str, reason: str) -> None:
        """Keep as an event what befell the loop: "refused" that the operator did not get, "log" that cannot go on.

        `kind` is such a word, and `reason` says why.
        """
        self._tell(kind, reason)

    @property
    def time(self) -> float:
        """The time (s) of the last step, or of the start."""
        return self._now

    def step(
        self,
        measurements: Mapping[str, Any],
        time: float,
        ages: Mapping[str, float] | None = None,
        reference: float | None = None,
    ) -> float:
        """The speed reference (rad/s) for the coming control step, at a time (s) that never runs backwards.

        `measurements` has what was measured, by channel; what is missing or no number is a fault, and no error. `ages`
        says how old (s) values are; `reference` (rad/s) is the one that the drive had meanwhile, where that is not the
        one that was given, as in shadow mode. Raises `ValueError` before `start`, and for a time that runs backwards.
        """
        if self._time is None:
            raise ValueError("Supervisor: step before start; call start(reference, target, measurements) first")
        passed = time - self._time
        if not 0.0 <= passed < float("inf"):
            raise refuse("Supervisor", "time", time, "s", f">= {self._time:g}, that of the step before")
        if reference is not None:
            if last_number(reference) is None:
                raise refuse("Supervisor", "reference", reference, "rad/s", "a finite number, or None")
            self.reference = float(reference)
        self._time = time
        period = self.controller.period
        faults = self._checks.faults(self.channels, measurements, ages or {})
        if passed > _LATE * period:
            faults["control step"] = f"late: {passed:.3g} s after the last one, over {_LATE * period:.3g} s"
        if passed < _EARLY * period:  # each step moves the reference by the rate of a whole one
            faults["control step"] = f"early: {passed:.3g} s after the last one, below {_EARLY * period:.3g} s"
        self._faults = faults
        self._watch_load({name: value for name, value in measurements.items() if name not in faults})
        self._change_state(faults, time)
        wanted = self._wanted(measurements, faults)
        self.reference = self._within(wanted, period)
        return self.reference

    def _change_state(self, faults: Mapping[str, str], time: float) -> None:
        if faults:
            self._sound = time
        limits = self.limits
        if self.state is State.NORMAL and faults:
            self._enter(State.HOLD, "fault", _words(faults))
        elif self.state in (State.HOLD, State.FALLBACK) and not faults and self._lasted(self._sound, limits.sound_time):
            self._enter(State.NORMAL, "sound", f"no fault for {limits.sound_time:g} s")
        elif self.state is State.HOLD and faults and self._lasted(self._since, limits.hold_time):
            self._enter(State.FALLBACK, "fault", f"{_words(faults)}; {limits.fallback} takes over")
        elif self.state is State.FALLBACK and faults and self._lasted(self._since, limits.fallback_time):
            self._ramp(f"{_words(faults)}; for {limits.fallback_time:g} s of {limits.fallback}")

    def _wanted(self, measurements: Mapping[str, Any], faults: Mapping[str, str]) -> float:
        """The reference that the state asks for."""
        if self.state is State.NORMAL:
            return self._act(measurements)
        if self.state is State.FALLBACK:
            return self.fallback.step(measurements, faults, self.reference, self.target)
        if self.state is State.RAMP:
            if self.reference == self._bottom:
                self._enter(State.STOPPED, "stopped", f"at {self._bottom:g} rad/s")
            return self._bottom
        return self.reference

    def _act(self, measurements: Mapping[str, Any]) -> float:
        """What the policy wants; held, and a fault, where it fails."""
        measured, controller = self._read(measurements), self.controller
        try:
            if self._begins_anew:  # with its running means as they were
                controller.start(self.reference, self.target, {**measured, **controller.statistics.values})
                self._begins_anew = False
            return controller.step(measured, reference=self.reference)
        except Exception as error:  # whatever it is, the rig turns on
            self._enter(State.HOLD, "fault", f"the policy failed: {str(error).splitlines()[0]}")
            return self.reference

    def _within(self, wanted: float, period: float) -> float:
        """The wanted reference within range and rate, and no higher than it was under an overload."""
        limits = self.limits
        stops = self.state in (State.RAMP, State.STOPPED)
        low = min(limits.lowest_reference, self._bottom) if stops else limits.lowest_reference
        inside = min(max(wanted, low), limits.highest_reference)
        if self._overload.is_there and self.state is not State.RAMP:
            inside = min(inside, self.reference)
        rate = limits.ramp if self.state is State.RAMP else limits.rate
        most = rate * period * (1.0 + 1e-12)
        given = min(max(inside, self.reference - most), self.reference + most)
        if self.state is State.RAMP and abs(given - self._bottom) < 1e-12:
            given = self._bottom
        clipped = self.state is State.NORMAL and abs(given - wanted) > 1e-9
        if clipped and not self._clipped:
            self._tell("limit", f"the policy wants {wanted:.4g} rad/s and gets {given:.4g} rad/s")
        self._clipped = clipped
        return given

    def _watch_load(self, measurements: Mapping[str, Any]) -> None:
        """Tell of an overload that begins; ramp down where one lasts too long, and at once from too high a speed."""
        was, reason = self._overload.is_there, self._overload.look(measurements, self._now)
        if self._overload.is_there and not was:
            self._tell("limit", f"{self._overload.words}: the reference rises no more")
        if reason and self.state not in (State.RAMP, State.STOPPED):
            self._ramp(reason)

    def _lasted(self, since: float, long: float) -> bool:
        return self._now - since >= long - _ROUNDING

    def _ramp(self, reason: str) -> None:
        self._bottom = min(self.limits.safe_speed, max(self.reference, 0.0))
        self._enter(State.RAMP, "ramp", reason)

    def _enter(self, state: State, kind: str, reason: str) -> None:
        earlier, self.state = self.state, state
        self._since = self._sound = self._now
        self._begins_anew = state is State.NORMAL and earlier in (State.HOLD, State.FALLBACK)
        self.fallback.rest()
        self._tell(kind, reason)

    def _tell(self, kind: str, reason: str) -> None:
        self.events.add(self._now, self.state.value, kind, reason)

    @property
    def _now(self) -> float:
        return 0.0 if self._time is None else self._time

    def _read(self, measurements: Mapping[str, Any]) -> dict[str, Any]:
        """Of what was measured what the policy wants."""
        return {name: measurements[name] for name in self.controller.channels}

    def _ranges(self) -> dict[str, tuple[float, float]]:
        """Where the policy still sees each channel, which is taken for what is plausible."""
        found, highest = {}, self.controller.highest
        for one in self.controller.file.about["scaling"]:
            reach = _CLIPPED * float(one["scale"])
            low, high = (0.0, highest) if one["offset"] == "target" else (float(one["offset"]),) * 2
            found[one["channel"]] = (low - reach, high + reach)
        found.pop(TARGET, None)
        return found


def _words(faults: Mapping[str, str]) -> str:
    return "; ".join(f"{name} {fault}" for name, fault in faults.items())
