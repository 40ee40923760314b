"""What every connected rig has in common, whatever protocol it speaks: what it said and what it measures."""

from __future__ import annotations

from typing import Any

from drillrig_env.deploy.readings import Readings

_PATIENCE, _AT_FIRST = 0.25, 50.0  # control periods, for measurements that are just underway, and for the first ones


class ConnectedRig:
    """A rig at `address`, with its `greeting` and control `period` (s of its time), whatever way they come here."""

    address: str
    greeting: dict[str, Any]
    channels: dict[str, str]
    period: float
    speed: float
    _readings: Readings

    def clock(self) -> float:
        """A time, s of the rig's."""
        raise NotImplementedError

    def ages(self) -> dict[str, float]:
        """How old (s) the latest measurements are, by channel."""
        return self._readings.ages(self.clock())

    def drive_reference(self) -> float:
        """The speed reference (rad/s) that the drive had when it last told, for shadow mode."""
        return self._readings.reference

    @property
    def target(self) -> float:
        """The speed (rad/s) that the rig's operator wants."""
        return float(self.greeting["target"])

    @property
    def _patience(self) -> float:
        """How long (s) measurements that are not there yet are waited for."""
        return (_PATIENCE if self._readings.values else _AT_FIRST) * self.period
