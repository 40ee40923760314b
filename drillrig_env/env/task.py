"""What an environment is: the rig, what its episodes draw, what is seen, what is rewarded; in one record."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeAlias

import numpy as np

from drillrig_env.allowed import Allowed, Made
from drillrig_env.drive import Drive
from drillrig_env.env.kernel import CONTROL_PERIOD, SLEW_LIMIT
from drillrig_env.env.reward import Reward
from drillrig_env.env.scenario import Scenario
from drillrig_env.env.sensors import LONGEST_DELAY, SENSORS, Sensors
from drillrig_env.parameters import checked, closest, parameter, refuse
from drillrig_env.rig import Rig

LONGEST_EPISODE = 1e5
"""Longest `duration` of an episode, s."""

_DELAYS = Allowed(0, LONGEST_DELAY, whole=True)
_DURATIONS = Allowed(CONTROL_PERIOD, LONGEST_EPISODE)


def _read_noise(noise: Any) -> float | dict[str, float]:
    """Noise as a task keeps it; `Sensors.layout` says what is wrong with it."""
    return dict(noise) if isinstance(noise, Mapping) else noise


def _read_delay(delay: Any) -> tuple[int, int]:
    """A delay in control steps as (lowest, highest)."""
    low, high = delay if isinstance(delay, Sequence) and len(delay) == 2 else (delay, delay)
    if not (_DELAYS.holds(low) and _DELAYS.holds(high) and np.ndim(low) == np.ndim(high) == 0 and low <= high):
        raise refuse("DrillRig", "delay", repr(delay), "control steps", f"{_DELAYS}, or such a pair (low, high)")
    return int(low), int(high)


def _read_duration(duration: Any) -> float:
    """The length of an episode in s, a whole number of control steps."""
    held = np.ndim(duration) == 0 and _DURATIONS.holds(duration)
    if not held or abs(round(duration / CONTROL_PERIOD) * CONTROL_PERIOD - duration) > 1e-6:
        raise refuse("DrillRig", "duration", repr(duration), "s", f"a multiple of {CONTROL_PERIOD}, {_DURATIONS}")
    return float(duration)


@dataclass(frozen=True)
class Task:
    """Everything that makes one environment differ from another; the arguments of every form of `DrillRig-v0`.

    Fields may be given in any way that the table of the environment names (a preset, a dictionary, a path) and are
    kept as records. Raises `ValueError` for a value that is not allowed.
    """

    rig: Rig = parameter(
        factory=Rig,
        meaning="the rig",
        allowed=Made(Rig.of, "a `Rig`, a dictionary of changes to the chapter's, or a TOML file"),
    )
    scenario: Scenario = parameter(
        factory=Scenario,
        meaning="what an episode draws",
        allowed=Made(Scenario.named, '`"nominal"`, `"default"`, `"wide"`, or a `Scenario`'),
    )
    sensors: Sensors = parameter(
        factory=lambda: SENSORS["state"],
        meaning="what is seen",
        allowed=Made(Sensors.named, '`"state"`, `"encoders"`, `"surface"`, or names of channels'),
    )
    noise: float | dict[str, float] | None = parameter(
        None,
        meaning="noise of the measurements",
        allowed=Made(_read_noise, "0 for none, 1 for the standard, or deviations by channel"),
        none="by sensors",
    )
    delay: tuple[int, int] | None = parameter(
        None,
        "control steps",
        "by which measurements come late",
        allowed=Made(_read_delay, f"0 to {LONGEST_DELAY}, or a range (low, high), drawn"),
        none="by sensors",
    )
    reward: Reward = parameter(
        factory=Reward,
        meaning="weights and shape of the reward",
        allowed=Made(Reward.of, '`"phases"`, a `Reward`, or changes to the default'),
    )
    slew_limit: float = parameter(
        SLEW_LIMIT, "rad/s^2", "largest rate of the speed reference", allowed=Allowed(0.0, 1e3, low_open=True)
    )
    drive: Drive | None = parameter(
        None,
        meaning="the drive's speed loop",
        allowed=Made(Drive.of, "`Drive(k_p, k_i, back_emf_share)`, or its fields"),
        none="the rig's",
    )
    duration: float = parameter(
        60.0,
        "s",
        "length of an episode",
        allowed=Made(_read_duration, f"a multiple of {CONTROL_PERIOD}, at most {LONGEST_EPISODE:g}"),
    )

    def __post_init__(self) -> None:
        for item in fields(self):
            value, meta = getattr(self, item.name), item.metadata
            if value is None and meta["none"]:
                continue
            kind = meta["allowed"]
            if isinstance(kind, Made):  # has sentences of its own
                object.__setattr__(self, item.name, kind.read(value))
            else:
                object.__setattr__(self, item.name, checked("DrillRig", item.name, value, meta["unit"], kind))
        self.sensors.layout(self.noise)  # says what is wrong with the noise

    @classmethod
    def of(cls, task: TaskLike = None, **given: Any) -> Task:
        """A task as environments take it: a `Task`, a dictionary of its fields or None, with some fields `given` anew.

        Raises `ValueError` for a value that is not allowed and for an unknown field of the dictionary, with the
        closest known one; `TypeError` for an unknown argument, as Python does and as libraries expect that try one.
        """
        if not isinstance(task, cls | Mapping | None):
            allowed = "a Task, or a dictionary of its fields; a rig goes by the name rig"
            raise refuse("DrillRig", "task", repr(task), "", allowed)
        changes = {**(task if isinstance(task, Mapping) else {}), **given}
        if "drive_gains" in changes:
            warnings.warn("the argument `drive_gains` is now `drive`", DeprecationWarning, stacklevel=3)
            changes["drive"] = changes.pop("drive_gains")
        for name in changes:
            if name not in TASK_FIELDS and name in given:
                raise TypeError(f"DrillRig: unexpected keyword argument {name!r}; {closest(name, TASK_FIELDS)}")
            if name not in TASK_FIELDS:
                raise ValueError(f"DrillRig: unknown field {name!r} of the task; {closest(name, TASK_FIELDS)}")
        return replace(task, **changes) if isinstance(task, cls) else cls(**changes)

    @property
    def delays(self) -> tuple[int, int]:
        """The lowest and the highest delay in control steps, with the sensors' own where none was given."""
        return self.delay or (self.sensors.delay, self.sensors.delay)

    @property
    def steps(self) -> int:
        """Control steps of an episode."""
        return round(self.duration / CONTROL_PERIOD)

    @property
    def speed_loop(self) -> Drive:
        """The drive of the episodes, with the rig's own where none was given."""
        return self.drive or Drive.of_rig(self.rig)


TaskLike: TypeAlias = Task | Mapping[str, Any] | None
"""What `Task.of` takes."""

TASK_FIELDS = tuple(item.name for item in fields(Task))
"""The names of the fields of a task."""

CHANGEABLE = ("scenario", "reward", "slew_limit")
"""Fields that an environment can be given anew while it lives."""
