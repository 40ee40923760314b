"""Current, torque and top speed above their limits: since when, and whether that is too long."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drillrig_env.deploy.checks import last_number
from drillrig_env.deploy.limits import Limits

_ROUNDING = 1e-9  # s


class Overload:
    """Whether current or torque are above their limits, as of the last `look`."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.words = ""
        self._since: float | None = None  # s

    @property
    def is_there(self) -> bool:
        """Whether one of them is above its limit."""
        return self._since is not None

    def look(self, measurements: Mapping[str, Any], time: float) -> str:
        """Look at measurements that can be trusted, at a time (s): why the rig must come down, empty where it need not.

        It must where current or torque have been above their limits for `overload_time`, and where the top speed is.
        """
        limits, over = self.limits, []
        for name, limit, unit in (("current", limits.current, "A"), ("string_torque", limits.torque, "N m")):
            value = last_number(measurements.get(name))
            if value is not None and abs(value) > limit:
                over.append(f"{name} = {value:.3g} {unit} is above {limit:g} {unit}")
        self.words = "; ".join(over)
        if not over:
            self._since = None
        elif self._since is None:
            self._since = time
        if self._since is not None and time - self._since >= limits.overload_time - _ROUNDING:
            return f"{self.words} for {time - self._since:.3g} s"
        speed = last_number(measurements.get("top_speed"))
        if speed is not None and abs(speed) > limits.top_speed:
            return f"top_speed = {speed:.4g} rad/s is above {limits.top_speed:g} rad/s"
        return ""
