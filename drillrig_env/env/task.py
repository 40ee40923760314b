"""What an environment is: the rig, what its episodes draw, what is seen, what is rewarded; in one record."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeAlias

import numpy as np

from drillrig_env.allowed import Allowed, Made, Switch
from drillrig_env.drive import Drive
from drillrig_env.env.reward import PRESETS as REWARDS
from drillrig_env.env.reward import Reward
from drillrig_env.env.scenario import LEAST_TARGET, Scenario
from drillrig_env.env.scenario import PRESETS as SCENARIOS
from drillrig_env.env.sensors import LONGEST_DELAY, SENSORS, Sensors
from drillrig_env.env.steady import check_steady
from drillrig_env.parameters import POSITIVE, checked, closest, parameter, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.scales import CONTROL_PERIOD, DURATION, LARGEST_REFERENCE, SLEW_LIMIT, Scales
from drillrig_env.slowest_mode import slowest_period
from drillrig_env.stepper.limits import check_computable

LONGEST_EPISODE = 1e5
"""Longest `duration` of an episode on the chapter's rig, s."""

_FASTEST, _SLOWEST = 200, 5
"""A control step lasts between these parts of the rig's slowest period."""

_ROUNDING = 1e-9

_HIGHEST_SLEW_LIMIT = 1e3
"""Highest slew limit that is taken on the chapter's rig, rad/s^2."""

_LARGEST_RATIO = 1e6
"""By how much a largest reference may differ from the one that belongs to the rig's period."""

_DELAYS = Allowed(0, LONGEST_DELAY, whole=True)


def _read_noise(noise: Any) -> float | dict[str, float]:
    """Noise as a task keeps it; `Sensors.layout` says what is wrong with it."""
    return dict(noise) if isinstance(noise, Mapping) else noise


def _read_delay(delay: Any) -> tuple[int, int]:
    """A delay in control steps as (lowest, highest)."""
    low, high = delay if isinstance(delay, Sequence) and len(delay) == 2 else (delay, delay)
    if not (_DELAYS.holds(low) and _DELAYS.holds(high) and np.ndim(low) == np.ndim(high) == 0 and low <= high):
        raise refuse("DrillRig", "delay", repr(delay), "control steps", f"{_DELAYS}, or such a pair (low, high)")
    return int(low), int(high)


def _read_duration(duration: Any, control_period: float, longest: float, given: bool) -> float:
    """The length of an episode in s, a whole number of control steps: the nearest one, but for a plain period of 0.1 s.

    Numbers of seconds that a person writes (`given`) are multiples of that one, and of no other rig's.
    """
    allowed = Allowed(control_period, longest)
    held = np.ndim(duration) == 0 and allowed.holds(duration)
    plain = given and control_period == CONTROL_PERIOD
    whole = round(duration / control_period) * control_period if held else 0.0
    if not held or (plain and abs(whole - duration) > 1e-6):
        raise refuse("DrillRig", "duration", repr(duration), "s", f"a multiple of {control_period:g}, {allowed}")
    return float(duration) if abs(whole - duration) <= 1e-5 * control_period else float(whole)


@dataclass(frozen=True)
class Task:
    """Everything that makes one environment differ from another; the arguments of every form of `DrillRig-v0`.

    Fields may be given in any way that the table of the environment names (a preset, a dictionary, a path) and are
    kept as records. What is not given is the rig's own: see `for_rig`. Raises `ValueError` for a value that is not
    allowed.

    >>> from drillrig_env import Rig, Task
    >>> Task().duration, round(Task.for_rig(Rig(J_1=0.0576)).control_period, 3)  # s
    (60.0, 0.132)
    """

    rig: Rig = parameter(
        factory=Rig,
        meaning="the rig",
        allowed=Made(Rig.of, "a `Rig`, a dictionary of changes to the chapter's, or a TOML file"),
    )
    scenario: Scenario = parameter(
        "default",
        meaning="what an episode draws",
        allowed=Made(Scenario.named, '`"nominal"`, `"default"`, `"wide"`, `"drift"`, a `Scenario`'),
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
        None,
        meaning="what is rewarded",
        none="Reward()",
        allowed=Made(Reward.of, '`"phases"`, a `Reward`, changes to the default, or `RewardTerms`'),
    )
    slew_limit: float = parameter(
        None,
        "rad/s^2",
        "largest rate of the speed reference",
        allowed=Made(float, f"> 0 and <= {_HIGHEST_SLEW_LIMIT:g}, by rig"),
        none=f"{SLEW_LIMIT}, by rig",
    )
    largest_reference: float = parameter(
        None,
        "rad/s",
        "upper end of the speed reference, the scale of all speeds",
        allowed=POSITIVE,
        none=f"{LARGEST_REFERENCE}, by rig",
    )
    control_period: float = parameter(
        None,
        "s",
        "length of a control step",
        allowed=Made(float, f"1/{_FASTEST} to 1/{_SLOWEST} of the rig's slowest period"),
        none=f"{CONTROL_PERIOD}, by rig",
    )
    drive: Drive | None = parameter(
        None,
        meaning="the drive's speed loop",
        allowed=Made(Drive.of, "`Drive(k_p, k_i, back_emf_share)`, or its fields"),
        none="the rig's",
    )
    privileged: bool = parameter(
        False,
        meaning="whether a critic's part is observed, apart from the policy's",
        allowed=Switch(),
    )
    duration: float = parameter(
        None,
        "s",
        "length of an episode",
        allowed=Made(float, f"a multiple of {CONTROL_PERIOD}, at most {LONGEST_EPISODE:g}, by rig"),
        none=f"{DURATION}, by rig",
    )

    def __post_init__(self) -> None:
        self._read("rig")
        slowest = slowest_period(self.rig)
        check_computable(self.rig)
        self._read("largest_reference")
        scales = Scales.of(self.rig, self.largest_reference)
        usual = LARGEST_REFERENCE * Scales.of(self.rig).speed
        speeds = Allowed(usual / _LARGEST_RATIO, usual * _LARGEST_RATIO)
        self._take("largest_reference", LARGEST_REFERENCE * scales.speed, speeds)
        rates = Allowed(0.0, _HIGHEST_SLEW_LIMIT * scales.rate, low_open=True)
        self._take("slew_limit", SLEW_LIMIT * scales.rate, rates)
        periods = Allowed((1.0 - _ROUNDING) * slowest / _FASTEST, (1.0 + _ROUNDING) * slowest / _SLOWEST)
        self._take("control_period", CONTROL_PERIOD * scales.time, periods)
        seen = replace(scales, drive_given=self.drive is not None)
        given = self.duration is not None
        duration = self.duration if given else DURATION * scales.duration
        longest = LONGEST_EPISODE * scales.duration
        object.__setattr__(self, "duration", _read_duration(duration, self.control_period, longest, given))
        object.__setattr__(self, "scenario", Scenario.named(self.scenario, scales))
        object.__setattr__(self, "sensors", Sensors.named(self.sensors).at(seen))
        object.__setattr__(self, "reward", Reward.of(self.reward, scales.time))
        for name in ("noise", "delay", "drive", "privileged"):
            self._read(name)
        check_steady(self.rig, self.drive)
        if self.drive is not None and self.drive.current_limit is not None and self.scenario.tilt is not None:
            raise refuse("Task", "current_limit", self.drive.current_limit, "A", "none where the disc is tilted")
        if not self.targets.holds(self.scenario.speed_target):
            raise refuse("Scenario", "speed_target", self.scenario.speed_target, "rad/s", f"each {self.targets}")
        targets = None if self.scenario.course is None else self.scenario.course.values("speed_target")
        for target in () if targets is None else targets:
            checked("Course", "speed_target", target, "rad/s", self.targets)
        self.sensors.layout(self.noise)  # says what is wrong with the noise

    def _read(self, name: str) -> None:
        """Keep a field as its kind reads it; None stays where it stands for something."""
        meta = self.__dataclass_fields__[name].metadata
        value, kind = getattr(self, name), meta["allowed"]
        if value is None and meta["none"]:
            return
        read = kind.read(value) if isinstance(kind, Made) else checked("DrillRig", name, value, meta["unit"], kind)
        object.__setattr__(self, name, read)  # what is `Made` has sentences of its own

    def _take(self, name: str, standard: float, allowed: Allowed = POSITIVE) -> None:
        """Keep a number as it is given, or the rig's `standard` in its place."""
        value, unit = getattr(self, name), self.__dataclass_fields__[name].metadata["unit"]
        taken = standard if value is None else checked("DrillRig", name, value, unit, allowed)
        object.__setattr__(self, name, taken)

    @classmethod
    def for_rig(cls, rig: RigLike = None, **given: Any) -> Task:
        """The task that belongs to a rig: every number that is not `given` grows with the rig's scales.

        Those numbers are control period, duration, largest speed reference and slew limit; targets, normal forces and
        v_b that are drawn; offsets, scales and noise of the channels; time constants and windows; and below which
        speed a bit stands. `drillrig_env.scales` has the rules. A rig does not tell at which speeds it is run: where
        no `largest_reference` is given, it is such that the rig turns as far in a period as the chapter's. On the
        chapter's rig all numbers are exactly those of the documentation.

        >>> task = Task.for_rig(Rig(), largest_reference=20.0)
        >>> task.slew_limit, task.scenario.speed_target, task.control_period
        (4.0, (2.0, 10.0), 0.1)
        """
        return cls(rig=Rig.of(rig), **given)

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
        return task._with(changes) if isinstance(task, cls) else cls(**changes)

    def _with(self, changes: Mapping[str, Any]) -> Task:
        """The task with some fields anew; on another rig, what was the rig's own is that rig's own."""
        if not {"rig", "largest_reference"} & set(changes):
            return replace(self, **changes)
        own = type(self).for_rig(self.rig, largest_reference=self.largest_reference)
        anew: dict[str, Any] = {}
        for name in ("slew_limit", "control_period", "duration"):
            if getattr(self, name) == getattr(own, name):
                anew[name] = None
        if self.largest_reference == type(self).for_rig(self.rig).largest_reference:
            anew["largest_reference"] = None
        for preset in SCENARIOS:
            if self.scenario == Scenario.named(preset, own.scales):
                anew["scenario"] = preset
        for kind in (None, *REWARDS):
            if self.reward == Reward.of(kind, own.scales.time):
                anew["reward"] = kind
        return replace(self, **{**anew, **changes})

    @property
    def delays(self) -> tuple[int, int]:
        """The lowest and the highest delay in control steps, with the sensors' own where none was given."""
        return self.delay or (self.sensors.delay, self.sensors.delay)

    @property
    def steps(self) -> int:
        """Control steps of an episode."""
        return round(self.duration / self.control_period)

    @property
    def scales(self) -> Scales:
        """By what the rig's numbers grow beside the chapter's."""
        return Scales.of(self.rig, self.largest_reference)

    @property
    def targets(self) -> Allowed:
        """The speed targets (rad/s) that are allowed."""
        return Allowed(LEAST_TARGET * self.scales.speed, self.largest_reference)

    @property
    def speed_loop(self) -> Drive:
        """The drive of the episodes, with the rig's own where none was given."""
        return self.drive or Drive.of_rig(self.rig)


TaskLike: TypeAlias = Task | Mapping[str, Any] | None
"""What `Task.of` takes."""

TASK_FIELDS = tuple(item.name for item in fields(Task))
"""The names of the fields of a task."""

CHANGEABLE = ("scenario", "reward", "slew_limit", "noise", "delay")
"""Fields that an environment can be given anew while it lives."""
