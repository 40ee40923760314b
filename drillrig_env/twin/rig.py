"""The rig itself: an episode's physics and instruments in parts of a control period, with a drive to be told a speed.

It is the environment's batch core with one rig. A control period is cut into `PARTS`, so that a speed reference acts
from the part in which it comes; what the instruments show over a period, they show of its parts together.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

import numpy as np

from drillrig_env.allowed import Allowed
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.sensors import CHANNELS, LONGEST_DELAY, Sensors
from drillrig_env.env.task import Task
from drillrig_env.parameters import checked
from drillrig_env.seeds import VALIDATION_SEEDS
from drillrig_env.verdict import WINDOW, is_mitigated

PARTS = 5
"""Parts of a control period."""

DELAYS = Allowed(0, LONGEST_DELAY // PARTS, whole=True)
"""Delays of the instruments that are allowed, in control steps."""

_DAY = 86_400.0  # s, on the chapter's rig
_SAMPLED = "bit_speed"  # of which a policy's running deviation wants more than one sample
_AVERAGED = "string_torque"
_SOURCES = {"bit_speed_mean": _SAMPLED, "bit_speed_deviation": _SAMPLED,
            "string_torque_mean": _AVERAGED, "string_torque_deviation": _AVERAGED}  # fmt: skip
_STILL = np.zeros((1, 1), dtype=np.float32)


class SimulatedRig:
    """A rig in an episode that goes on for a day, and the instruments of `sensors`.

    `seed` draws target, load, friction, start and noise as in an episode of the environment, whose load step comes
    within its usual length; `options` pins any of it, as for a reset. `noise` multiplies the standard noise of the
    channels and `delay` is in control steps; None is the sensors' own of either. `task` has arguments of the
    environment, such as `rig` and `drive`. Raises `ValueError` for what is not allowed.

    `channels` are the units by name, `period` is the control period, `part` the length of a part (s).
    """

    def __init__(
        self,
        seed: int = VALIDATION_SEEDS.start,
        sensors: str = "surface",
        noise: float | None = None,
        delay: int | None = None,
        options: Mapping[str, Any] | None = None,
        **task: Any,
    ) -> None:
        usual, shown = Task(**task), Sensors.named(sensors)
        self.period = usual.control_period
        self.part = self.period / PARTS
        asked = shown.delay if delay is None else checked("SimulatedRig", "delay", delay, "control steps", DELAYS)
        measured = [one.name for one in shown.channels if one.measured]
        names = tuple(dict.fromkeys(_SOURCES.get(name, name) for name in measured))
        deviations = Sensors.named(names).at(usual.scales).layout(shown.noise if noise is None else noise)["noise"]
        by_channel = dict(zip(names, deviations.tolist(), strict=True))
        if _AVERAGED in by_channel:  # so that the mean over the parts has it
            by_channel[_AVERAGED] *= np.sqrt(PARTS)
        long = _DAY * usual.scales.duration
        anew = {"sensors": names, "noise": by_channel, "delay": asked * PARTS, "duration": long}
        self.core = EpisodeBatch(1, Task(**{**task, **anew, "control_period": self.part}), threads=1)
        self.core.reset(np.arange(1), first_uniforms(seed, 1), options)
        for time in ("load_times", "target_time"):  # drawn as shares of the episode
            if "load_steps" not in (options or {}):
                self.core.episodes[time] *= usual.duration / self.core.duration
        self.usual = usual
        self.delay = asked
        units = {channel.name: channel.unit for channel in CHANNELS}
        self.channels: dict[str, str] = {name: units[name] for name in names}
        self._recent = deque([self.core.observations[0]], maxlen=PARTS)
        window = round(WINDOW * usual.scales.time / self.part)
        self._bit: deque[tuple[float, float, float]] = deque(maxlen=window)

    @property
    def time(self) -> float:
        """Since the start, s."""
        return int(self.core.episodes["step"][0]) * self.part

    @property
    def reference(self) -> float:
        """The speed reference that the drive has, rad/s; to be set within 0 and `largest_reference` of the task."""
        return float(self.core.episodes["speed_reference"][0])

    @reference.setter
    def reference(self, speed: float) -> None:
        self.core.episodes["speed_reference"] = speed

    @property
    def target(self) -> float:
        """The speed target of the episode, rad/s."""
        return float(self.core.episodes["speed_target"][0])

    @property
    def is_over(self) -> bool:
        """Whether the day is over, from when on nothing moves."""
        return bool(self.core.ended[0])

    @property
    def bit_speed_deviation(self) -> float:
        """The running deviation of the bit speed, rad/s: how much it sticks and slips, which no surface shows."""
        return float(np.sqrt(self.core.episodes["variance"][0]))

    @property
    def is_mitigated(self) -> bool:
        """The environment's verdict on the last seconds, over the window of its episodes."""
        if not self._bit:
            return False
        lowest, highest, average = np.array(self._bit).T
        scale = self.core.task.scales.speed
        return bool(is_mitigated(lowest.min(), highest.max(), average.mean(), self.target, scale))

    def advance(self) -> None:
        """Let a part of a control period pass, with the speed reference as it is."""
        self.core.step(_STILL)
        episode = self.core.episodes[0]
        self._recent.append(self.core.observations[0])
        self._bit.append((episode["lowest"], episode["highest"], episode["average"]))

    def measure(self) -> dict[str, Any]:
        """What the instruments show of the last control period, by channel in SI units; of the bit speed its parts."""
        seen = self.core.sensors.values(np.array(self._recent), self.target)
        shown: dict[str, Any] = {name: float(values[-1]) for name, values in seen.items()}
        if _AVERAGED in shown:
            shown[_AVERAGED] = float(seen[_AVERAGED].mean())
        if _SAMPLED in shown:
            shown[_SAMPLED] = seen[_SAMPLED].tolist()
        return shown
