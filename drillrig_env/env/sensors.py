"""What the policy sees: named channels, each with its unit, offset and scale.

An observation is (value - offset) / scale of its channels, clipped to +-LIMIT. The offset of a speed
is the speed target: what matters is the distance from it, and 5 % of a slow target would be lost in
the scale of the fastest. `Sensors.value` turns an observation back into physical numbers by name.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from drillrig_env.model import STATE_NAMES
from drillrig_env.parameters import closest

LIMIT = 10.0
"""Observations are clipped here; on the default draws they stay within about +-3."""


@dataclass(frozen=True)
class Channel:
    """One measured quantity. Its observation is (value - offset) / scale; the offset "target" is the speed target."""

    name: str
    unit: str
    offset: float | Literal["target"]
    scale: float
    meaning: str


CHANNELS = (
    Channel("twist_12", "rad", -0.3, 0.3, "shaft twist between disc 1 and disc 2"),
    Channel("twist_23", "rad", -1.0, 1.0, "shaft twist between disc 2 and the motor's output"),
    Channel("bit_speed", "rad/s", "target", 2.0, "speed of disc 1, the bit"),
    Channel("collar_speed", "rad/s", "target", 2.0, "speed of disc 2, the collars"),
    Channel("top_speed", "rad/s", "target", 2.0, "speed of the motor's output"),
    Channel("current", "A", 1.3, 0.5, "armature current"),
    Channel("speed_error_integral", "rad", 2.1, 1.0, "integral of speed reference less top speed"),
    Channel("speed_reference", "rad/s", "target", 2.0, "speed reference omega_ref"),
    Channel("speed_target", "rad/s", 3.0, 2.0, "what the operator wants, omega*"),
    Channel("bit_speed_mean", "rad/s", "target", 1.0, "running mean of the bit speed"),
    Channel("bit_speed_deviation", "rad/s", 1.0, 1.0, "running standard deviation of the bit speed"),
)
"""Everything that can be measured, in the order in which the batch core lays it out."""

_NAMES = tuple(channel.name for channel in CHANNELS)
_SENSORS: dict[str, tuple[str, ...]] = {
    "state": (*STATE_NAMES, "speed_reference", "speed_target", "bit_speed_mean", "bit_speed_deviation"),
}


@dataclass(frozen=True)
class Sensors:
    """A set of channels by name: the layout of an observation."""

    name: str
    channels: tuple[Channel, ...]

    @classmethod
    def named(cls, name: str) -> Sensors:
        """The sensors of that name: "state" shows everything. `ValueError` for an unknown one."""
        if name not in _SENSORS:
            raise ValueError(f"sensors = {name!r} is not known; {closest(name, _SENSORS)}")
        return cls(name, tuple(CHANNELS[_NAMES.index(channel)] for channel in _SENSORS[name]))

    @property
    def names(self) -> tuple[str, ...]:
        """The channels' names, in the observation's order."""
        return tuple(channel.name for channel in self.channels)

    @property
    def layout(self) -> np.ndarray:
        """Columns index into CHANNELS, offset, scale and 1 where the target is the offset; shape (channels, 4)."""
        rows = [
            (_NAMES.index(c.name), 0.0, c.scale, 1.0)
            if c.offset == "target"
            else (_NAMES.index(c.name), c.offset, c.scale, 0.0)
            for c in self.channels
        ]
        return np.array(rows, dtype=float)

    def value(self, observation: np.ndarray, name: str) -> np.ndarray:
        """A channel's physical value from observations of shape (..., channels); shape (...)."""
        if name not in self.names:
            raise ValueError(f"the sensors {self.name!r} have no channel {name!r}; {closest(name, self.names)}")
        index = self.names.index(name)
        channel = self.channels[index]
        offset = self.value(observation, "speed_target") if channel.offset == "target" else channel.offset
        return np.asarray(np.asarray(observation, dtype=float)[..., index] * channel.scale + offset)

    def values(self, observation: np.ndarray) -> dict[str, np.ndarray]:
        """All channels' physical values by name."""
        return {name: self.value(observation, name) for name in self.names}
