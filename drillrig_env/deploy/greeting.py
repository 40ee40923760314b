"""What a rig says of itself when a controller connects, checked before anything stands on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any


@dataclass(frozen=True)
class Greeting:
    """Of a greeting what every connection needs; docs/line_protocol.md has all of it. Times in s, speeds in rad/s."""

    channels: dict[str, str]  # unit by name
    period: float
    speed: float  # times the system's time
    waits: bool
    time: float
    reference: float
    target: float

    @classmethod
    def of(cls, said: Any) -> Greeting:
        """What was said. `KeyError`, `TypeError` or `ValueError` where it is no greeting of a rig."""
        numbers = {name: float(said[name]) for name in ("period", "speed", "time", "reference", "target")}
        if not (all(map(isfinite, numbers.values())) and numbers["period"] > 0.0 and numbers["speed"] > 0.0):
            raise ValueError(f"{numbers} are not allowed; allowed: finite, period and speed > 0")
        for name in ("drive", "parameters"):
            if not isinstance(said.get(name, {}), Mapping):
                raise TypeError(f"{name} = {said[name]!r} is no object")
        channels = {str(name): str(unit) for name, unit in dict(said["channels"]).items()}
        return cls(channels, waits=bool(said.get("waits", False)), **numbers)
