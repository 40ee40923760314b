"""What a calibrated rig means: its critical speed and where stick-slip ends, each with how well it is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.borders import Borders, borders
from drillrig_env.calibrate.calibration import NOT_BY_RECORDS, Calibration

SPEEDS = ("critical speed", "end of stick-slip")
"""The speeds, as `Borders` has them."""

_NONE = ("steady rotation is stable at every speed", "there is no stick-slip")

_WIDE = 3.0
"""Above so large a ratio of its ends an interval says that the records do not determine a speed."""

LEAST_SHARE, _LEAST_DRAWS = 0.9, 16
"""Share of the draws that must have a speed for an interval, and draws that there must be."""


@dataclass(frozen=True)
class Meaning:
    """A speed (rad/s) of the best rig, and its 90 % interval, as `Borders` has them: 0 is none, NaN is not known.

    `draws` of them were asked, and `told` of these tell it.
    """

    name: str
    value: float
    low: float
    high: float
    draws: int = 64
    told: int = 64

    @property
    def determined(self) -> bool:
        """Whether the records tell it at all."""
        return bool(np.isfinite(self.low) and np.isfinite(self.value) and self.high < _WIDE * self.low)

    def __str__(self) -> str:
        none = _NONE[SPEEDS.index(self.name)] if self.name in SPEEDS else "there is none"
        if self.told < LEAST_SHARE * self.draws or np.isnan(self.value):
            return f"{self.name}: cannot be told for {self.draws - self.told} of {self.draws} rigs drawn"
        if self.draws < _LEAST_DRAWS:
            return f"{self.name}: {self.value:.3f} rad/s, too few rigs drawn for an interval ({self.draws})"
        if self.value == self.high == 0.0:
            return f"{self.name}: none, {none}"
        if self.low == np.inf:
            return f"{self.name}: none, steady rotation is stable at no speed"
        if not self.determined:
            return f"{self.name}: {NOT_BY_RECORDS} ({self.low:.3g} to {self.high:.3g} rad/s)"
        return f"{self.name}: {self.value:.3f} rad/s ({self.low:.3f} to {self.high:.3f})"


def meanings(calibration: Calibration, normal_force: float, draws: int | None = None) -> list[Meaning]:
    """Critical speed and end of stick-slip at a normal force (N), over the first `draws` joint draws; default all."""
    return meanings_of(borders(calibration, [normal_force], draws))


def meanings_of(found: Borders) -> list[Meaning]:
    """Critical speed and end of stick-slip at the last of the normal forces."""
    means = []
    for i, name in enumerate(SPEEDS):
        values = found.draws[:, i, -1]
        told = int(np.count_nonzero(~np.isnan(values)))
        low, high = band(values)
        means.append(Meaning(name, float(found.best[i, -1]), float(low), float(high), len(values), told))
    return means


def band(values: FloatArray) -> FloatArray:
    """The ends of the 90 % interval of speeds of draws, (draws, ...), shape (2, ...); NaN where too few draws tell."""
    if len(values) < _LEAST_DRAWS:
        return np.full((2, *values.shape[1:]), np.nan)
    enough = np.mean(~np.isnan(values), axis=0) >= LEAST_SHARE
    ends = np.nanquantile(np.where(enough, values, 0.0), [0.05, 0.95], axis=0, method="nearest")
    return np.where(enough, ends, np.nan)
