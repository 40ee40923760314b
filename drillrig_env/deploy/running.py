"""Running means and deviations as the environment makes them, from what is measured at each control step.

Of the bit speed, with the gain g = 1 - exp(-h / n / T) of n samples in a control step of length h,

    d = x - mean,  mean <- mean + g d,  variance <- (1 - g) (variance + g d^2),

sample by sample; of the torque, once a control step, d likewise, mean <- mean + g_m d and
variance <- variance + g_v (d^2 - variance). A deviation is the root of the variance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import exp, sqrt
from typing import Any


class RunningStatistics:
    """The means and deviations that a policy's file asks for; `statistics` are its own of that name.

    `period` is the control period in s.
    """

    def __init__(self, statistics: Sequence[Mapping[str, Any]], period: float) -> None:
        self.asked = list(statistics)
        self.period = period
        self.sources = tuple(dict.fromkeys(one["of"] for one in self.asked))
        self._of = {source: [one for one in self.asked if one["of"] == source] for source in self.sources}
        self._mean: dict[str, float] = {}
        self._variance: dict[str, float] = {}

    def begin(self, measured: Mapping[str, Sequence[float]]) -> None:
        """Begin as a rig that has always turned as it does now: means as measured, no deviation.

        `measured` has the samples of each source, and may have the statistics themselves, where they are known.
        """
        self._mean = {source: float(measured[source][-1]) for source in self.sources}
        self._variance = dict.fromkeys(self.sources, 0.0)
        for one in self.asked:
            if one["channel"] in measured:
                known = float(measured[one["channel"]][-1])
                kept = self._mean if one["is"] == "mean" else self._variance
                kept[one["of"]] = known if one["is"] == "mean" else known * known

    def update(self, measured: Mapping[str, Sequence[float]]) -> None:
        """Take in the samples (in time's order) that each source showed in a control step."""
        for source in self.sources:
            for sample in measured[source]:
                self._take(source, sample, len(measured[source]))

    def _take(self, source: str, sample: float, samples: int) -> None:
        one = self._of[source][0]
        deviation = sample - self._mean[source]
        if one["samples"] > 1:
            gain = self._gain(one["time_constant"], samples)
            step = gain * deviation
            self._mean[source] += step
            self._variance[source] = (1.0 - gain) * (self._variance[source] + deviation * step)
            return
        slow = one.get("mean_time_constant", one["time_constant"])
        fast = next((o["time_constant"] for o in self._of[source] if o["is"] == "deviation"), slow)
        self._mean[source] += self._gain(slow, samples) * deviation
        self._variance[source] += self._gain(fast, samples) * (deviation * deviation - self._variance[source])

    def _gain(self, time_constant: float, samples: int) -> float:
        return 1.0 - exp(-self.period / samples / time_constant)

    @property
    def values(self) -> dict[str, float]:
        """Every statistic by its channel."""
        return {
            one["channel"]: self._mean[one["of"]] if one["is"] == "mean" else sqrt(self._variance[one["of"]])
            for one in self.asked
        }
