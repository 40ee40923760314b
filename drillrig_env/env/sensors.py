"""What the policy sees: named channels, each with its unit, offset, scale and noise.

An observation is (value - offset) / scale of its channels, clipped to +-LIMIT. The offset of a speed
is the speed target: what matters is the distance from it, and 5 % of a slow target would be lost in
the scale of the fastest. `Sensors.value` turns an observation back into physical numbers by name.

The torque into the string is what a drive makes of its own current and speed. Integrated over one
control step of length h, (4-5c) reads

    mean T_s = eta K_T mean i - eta^2 C_m mean x_5 - eta T_f - J_3 (x_5(t) - x_5(t - h)) / h,

so a drive that samples current and speed every millisecond and averages over the step knows the mean
torque of the step within 0.005 N m (1 % of a common load), if it knows the motor: half a step late, and
with the noise of the channel.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from drillrig_env import markdown
from drillrig_env.arrays import Quantity
from drillrig_env.model import STATE_NAMES
from drillrig_env.parameters import NOT_NEGATIVE, checked, closest, refuse
from drillrig_env.scales import Scales

LIMIT = 10.0
"""Observations are clipped here; on the default draws they stay within about +-3."""

LONGEST_DELAY = 10
"""Most control steps by which measurements may come late."""

TORQUE_MEAN_TIME, TORQUE_DEVIATION_TIME = 10.0, 2.5
"""Time constants (s) of the running mean of the torque into the string, and of its deviation from that; the
chapter's."""

LAYOUT = np.dtype(
    [
        ("source", "i8"),  # index into CHANNELS
        ("offset", "f8"),
        ("from_target", "f8"),  # 1 where the speed target adds to the offset
        ("scale", "f8"),
        ("noise", "f8"),  # standard deviation, in the channel's unit
        ("late", "b1"),  # whether the delay holds for it
    ],
    align=True,
)
"""How the batch core makes an observation, a record a channel."""


@dataclass(frozen=True)
class Channel:
    """One quantity that a policy may see.

    `name` is what it is called, `meaning` says what it is.

    Its observation is (value - offset) / scale; the offset "target" is the speed target. `noise` is the
    standard deviation of an ordinary instrument for it, in `unit`. What the controller sets itself is
    not `measured`: never noisy and never late.

    >>> sensors = Sensors("mine", (Channel("top_speed", "rad/s", "target", 2.0, 0.02, "of the motor"),), noise=1.0)
    >>> [one.name for one in sensors.channels]
    ['top_speed']
    """

    name: str
    unit: str
    offset: float | Literal["target"]
    scale: float
    noise: float
    meaning: str
    measured: bool = True

    def at(self, scales: Scales) -> Channel:
        """The channel of another rig that corresponds to this one of the chapter's. `scales` are that rig's."""
        level, swing = _GROWING.get(self.name) or _GROWING[self.unit]
        grown = getattr(scales, swing)
        offset = self.offset if self.offset == "target" else self.offset * getattr(scales, level)
        return replace(self, offset=offset, scale=self.scale * grown, noise=self.noise * grown)


_GROWING = {
    "twist_12": ("twist_12", "twist_12_swing"),
    "twist_23": ("twist_23", "twist_23_swing"),
    "speed_error_integral": ("speed_error", "speed_error_swing"),
    "rad/s": ("speed", "speed"),
    "A": ("current", "current_swing"),
    "V": ("voltage", "voltage_swing"),
    "N m": ("load", "torque"),
}
"""The scales of a rig by which offset, and scale and noise, of a channel grow, by name or unit."""

CHANNELS = (
    Channel("twist_12", "rad", -0.3, 0.3, 0.005, "shaft twist between disc 1 (bit) and disc 2 (collars)"),
    Channel("twist_23", "rad", -1.0, 1.0, 0.005, "shaft twist between disc 2 and the motor's output"),
    Channel("bit_speed", "rad/s", "target", 2.0, 0.02, "speed of disc 1, the bit"),
    Channel("collar_speed", "rad/s", "target", 2.0, 0.02, "speed of disc 2, the collars"),
    Channel("top_speed", "rad/s", "target", 2.0, 0.02, "speed of the motor's output"),
    Channel("current", "A", 1.3, 0.5, 0.02, "armature current"),
    Channel("speed_error_integral", "rad", 2.1, 1.0, 0.0, "integral of speed reference less top speed"),
    Channel("speed_reference", "rad/s", "target", 1.0, 0.0, "speed reference omega_ref", measured=False),
    Channel("speed_target", "rad/s", 3.0, 2.0, 0.0, "what the operator wants, omega*", measured=False),
    Channel("bit_speed_mean", "rad/s", "target", 1.0, 0.01, "running mean of the bit speed"),
    Channel("bit_speed_deviation", "rad/s", 1.0, 1.0, 0.01, "running standard deviation of the bit speed"),
    Channel("voltage", "V", 2.0, 1.0, 0.05, "armature voltage, from the speed loop"),
    Channel("string_torque", "N m", 0.3, 0.3, 0.02, "torque into the string, as the drive estimates it"),
    Channel("string_torque_mean", "N m", 0.3, 0.2, 0.002, "running mean of the torque into the string"),
    Channel("string_torque_deviation", "N m", 0.2, 0.2, 0.002, "running deviation of that torque"),
)
"""Everything that can be seen, in the order in which the batch core lays it out, on the chapter's rig."""

_BY_NAME = {channel.name: channel for channel in CHANNELS}
_INDEX = {channel.name: index for index, channel in enumerate(CHANNELS)}


@dataclass(frozen=True)
class Sensors:
    """A set of channels by name, the layout of an observation, and how good it is by default.

    `noise` multiplies the channels' standard noise, `delay` is in control steps.

    >>> import gymnasium as gym
    >>> env = gym.make("DrillRigSurface-v0")
    >>> observation, info = env.reset(seed=0)
    >>> sorted(env.unwrapped.sensors.values(observation))[:2]
    ['current', 'speed_reference']
    """

    name: str
    channels: tuple[Channel, ...]
    noise: float = 0.0
    delay: int = 0

    @classmethod
    def named(cls, sensors: str | Sequence[str] | Mapping[str, Any] | Sensors) -> Sensors:
        """Sensors by name: "state", "encoders" or "surface"; or of one's own, from names of channels.

        `sensors` are such a name, such names, or a record or dictionary of `Sensors`.

        `ValueError` for an unknown name, an empty set or a channel that is named twice.
        """
        if isinstance(sensors, Sensors):
            return sensors
        if isinstance(sensors, str):
            if sensors not in SENSORS:
                raise ValueError(
                    f"sensors = {sensors!r} is not known; {closest(sensors, SENSORS)}, or names of channels"
                )
            return SENSORS[sensors]
        if isinstance(sensors, Mapping) and {"name", "channels", "noise", "delay"} == set(sensors):  # as JSON has them
            channels = tuple(_BY_NAME[channel["name"]] for channel in sensors["channels"])
            return cls(sensors["name"], channels, sensors["noise"], sensors["delay"])
        try:
            names = tuple(sensors)
        except TypeError as error:
            allowed = f"{', '.join(SENSORS)}, or names of channels"
            raise refuse("DrillRig", "sensors", repr(sensors), "", allowed) from error
        for name in names:
            if not isinstance(name, str) or name not in _BY_NAME:
                raise ValueError(f"sensors: unknown channel {name!r}; {closest(name, _BY_NAME)}")
        if not names or len(set(names)) < len(names):
            raise refuse("sensors", "channels", names, "", "one or more different names")
        return cls(", ".join(names), tuple(_BY_NAME[name] for name in names))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The channels' names, in the observation's order."""
        return tuple(channel.name for channel in self.channels)

    @property
    def asked(self) -> str | tuple[str, ...]:
        """What `named` makes them from: the name of a set, which has noise and delay, or names of channels."""
        return self.name if self.name in SENSORS else self.names

    def at(self, scales: Scales) -> Sensors:
        """The same sensors on a rig with such scales: its offsets, scales and noise."""
        made = replace(self, channels=tuple(_BY_NAME[name].at(scales) for name in self.names))
        return self if made == self else made

    def layout(self, noise: float | Mapping[str, float] | None = None) -> np.ndarray:
        """The records of LAYOUT for the batch core.

        `noise` multiplies every channel's standard noise, or gives standard deviations by name (none
        for the others); None is the sensors' own. `ValueError` for an unknown channel or a negative number.
        """
        layout = np.zeros(len(self.channels), dtype=LAYOUT)
        for row, channel in zip(layout, self.channels, strict=True):
            target = channel.offset == "target"
            offset = 0.0 if channel.offset == "target" else channel.offset
            row["source"], row["offset"], row["from_target"] = _INDEX[channel.name], offset, float(target)
            row["scale"], row["late"] = channel.scale, channel.measured
        layout["noise"] = self._deviations(self.noise if noise is None else noise)
        return layout

    def _deviations(self, noise: float | Mapping[str, float]) -> list[float]:
        if not isinstance(noise, Mapping):
            if np.ndim(noise) != 0 or not NOT_NEGATIVE.holds(noise):
                raise refuse("DrillRig", "noise", repr(noise), "", f"{NOT_NEGATIVE}, or standard deviations by channel")
            return [noise * channel.noise for channel in self.channels]
        for name, deviation in noise.items():
            measured = [channel.name for channel in self.channels if channel.measured]
            if name not in measured:
                raise ValueError(f"noise: {name!r} is not a measured channel here; {closest(name, measured)}")
            checked("noise", name, deviation, _BY_NAME[name].unit, NOT_NEGATIVE)
        return [float(noise.get(channel.name, 0.0)) for channel in self.channels]

    def value(self, observation: np.ndarray, name: str, speed_target: Quantity | None = None) -> np.ndarray:
        """A channel's physical value from observations of shape (..., channels); shape (...).

        `observation` is one or many of them, `name` the channel's.

        Speeds are seen from the speed target; where these sensors do not show it, give `speed_target` (rad/s).
        `ValueError` where it is needed and not known, for a channel that is not there, and for another shape.
        """
        if name not in self.names:
            raise ValueError(f"the sensors {self.name!r} have no channel {name!r}; {closest(name, self.names)}")
        seen, index = self._read(observation), self.names.index(name)
        target = self._target(seen, speed_target) if self.channels[index].offset == "target" else None
        found = self._seen(seen, index, target)
        if found is None:
            raise ValueError(
                f"{name} is seen from the speed target, which the sensors {self.name!r} do not show; "
                "give speed_target in rad/s"
            )
        return found

    def values(self, observation: np.ndarray, speed_target: Quantity | None = None) -> dict[str, np.ndarray]:
        """The channels' physical values by name, from observations of shape (..., channels).

        `observation` is one or many of them.

        Where neither these sensors nor `speed_target` (rad/s) tell the target, what is seen from it is left out.
        """
        seen = self._read(observation)
        target = self._target(seen, speed_target)
        found = {name: self._seen(seen, index, target) for index, name in enumerate(self.names)}
        return {name: value for name, value in found.items() if value is not None}

    def _read(self, observation: np.ndarray) -> np.ndarray:
        try:
            seen = np.asarray(observation, dtype=float)
        except (TypeError, ValueError) as error:
            raise refuse("Sensors", "observation", repr(observation), "", "an array of numbers") from error
        if seen.shape[-1:] != (len(self.channels),):
            raise refuse("Sensors", "shape of the observation", seen.shape, "", f"(..., {len(self.channels)})")
        return seen

    def _target(self, seen: np.ndarray, speed_target: Quantity | None) -> Quantity | None:
        shown = speed_target is None and "speed_target" in self.names
        return self._seen(seen, self.names.index("speed_target"), None) if shown else speed_target

    def _seen(self, seen: np.ndarray, index: int, target: Quantity | None) -> np.ndarray | None:
        """The physical value of a channel; None where it is seen from a target that is not known."""
        channel = self.channels[index]
        offset = target if channel.offset == "target" else channel.offset
        return None if offset is None else np.asarray(seen[..., index] * channel.scale + offset)


def _sensors(name: str, channels: Sequence[str], noise: float = 0.0, delay: int = 0) -> Sensors:
    return Sensors(name, tuple(_BY_NAME[channel] for channel in channels), noise, delay)


_OWN = ("speed_reference", "speed_target")
SENSORS = {
    "state": _sensors("state", (*STATE_NAMES, *_OWN, "bit_speed_mean", "bit_speed_deviation", "string_torque_mean")),
    "encoders": _sensors("encoders", ("bit_speed", "collar_speed", "top_speed", *_OWN)),
    "surface": _sensors(
        "surface",
        (
            "top_speed",
            "current",
            "voltage",
            "string_torque",
            "string_torque_mean",
            "string_torque_deviation",
            *_OWN,
        ),
        noise=1.0,
        delay=1,
    ),
}
"""What a policy may be given: everything, what the laboratory rig's encoders show, or what a drilling rig shows."""


def observation_table(sensors: str | Sequence[str] = "state") -> str:
    """A Markdown table of the channels of some sensors: number, name and meaning, unit, offset, scale, noise.

    The noise is the standard deviation that the sensors have by default, in the channel's unit.

    >>> print(observation_table("encoders"))
    | Num | Channel | Unit | Offset | Scale | Noise |
    |---|---|---|---|---|---|
    | 0 | `bit_speed`, speed of disc 1, the bit | rad/s | target | 2.0 | 0 |
    | 1 | `collar_speed`, speed of disc 2, the collars | rad/s | target | 2.0 | 0 |
    | 2 | `top_speed`, speed of the motor's output | rad/s | target | 2.0 | 0 |
    | 3 | `speed_reference`, speed reference omega_ref | rad/s | target | 1.0 | 0 |
    | 4 | `speed_target`, what the operator wants, omega* | rad/s | 3.0 | 2.0 | 0 |
    """
    chosen = Sensors.named(sensors)
    rows = [
        (
            number,
            f"`{channel.name}`, {channel.meaning}",
            channel.unit,
            channel.offset,
            channel.scale,
            f"{chosen.noise * channel.noise:g}",
        )
        for number, channel in enumerate(chosen.channels)
    ]
    return markdown.table(("Num", "Channel", "Unit", "Offset", "Scale", "Noise"), rows, words=6)
