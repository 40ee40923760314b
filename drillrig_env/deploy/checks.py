"""Whether measurements can be trusted: none missing, stale, frozen or beyond what is plausible."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

from drillrig_env.deploy.limits import Limits

_SHOWN = 40  # characters of what is no number
Given = Mapping[str, Any]


class Checks:
    """The checks of one rig's measurements, by channel; it remembers since when each stands still.

    A value is plausible within `limits.plausible`, and where that is silent within `ranges`, (low, high) by channel.
    """

    def __init__(self, limits: Limits, ranges: Mapping[str, tuple[float, float]]) -> None:
        self.limits = limits
        self.ranges = {**ranges, **limits.plausible}
        self._last: dict[str, float] = {}
        self._still: dict[str, int] = {}

    def faults(self, channels: Sequence[str], measured: Given, ages: Mapping[str, float]) -> dict[str, str]:
        """What is wrong with the channels that are asked for, by channel, in words; empty where all can be trusted.

        `measured` may lack channels and hold what is no number; `ages` (s) says how old values are, 0 where it is
        silent. To be called once a control step.
        """
        found = {name: self._fault(name, measured.get(name), ages.get(name, 0.0)) for name in channels}
        return {name: fault for name, fault in found.items() if fault}

    def _fault(self, name: str, value: Any, age: float) -> str:
        number = last_number(value)
        if number is None:
            return "missing" if value is None else f"{ascii(value)[:_SHOWN]} is no finite number"
        self._still[name] = self._still.get(name, 0) + 1 if number == self._last.get(name) else 0
        self._last[name] = number
        if not age <= self.limits.stale:
            return f"stale: {age:.3g} s old, over {self.limits.stale:g} s"
        if self._still[name] >= self.limits.frozen:
            return f"frozen: {number:g} for {self._still[name]} control steps"
        low, high = self.ranges.get(name, (float("-inf"), float("inf")))
        if not low <= number <= high:
            return f"implausible: {number:g}, not within {low:g} to {high:g}"
        return ""


def last_number(value: Any) -> float | None:
    """A value as a finite number, of several samples the last one; None where it is none, or a sample is none."""
    if type(value) is float:  # the common case
        return value if isfinite(value) else None
    try:
        samples = list(value) if hasattr(value, "__len__") and not isinstance(value, str) else [value]
        numbers = [float(one) for one in samples if not isinstance(one, bool | str)]
    except (TypeError, ValueError, OverflowError):
        return None
    sound = len(numbers) == len(samples) > 0 and all(map(isfinite, numbers))
    return numbers[-1] if sound else None
