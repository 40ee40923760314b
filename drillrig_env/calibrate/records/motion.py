"""What a signal does, without a model of it: how long it takes from peak to peak, and whether that is seen."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray

_SWINGS = 0.1  # of the largest value: with a smaller standard deviation it is rotation with noise
_STICKS = 0.25  # with a larger one it sticks and slips: a sine between 0 and its peak has 0.35
_HYSTERESIS = 0.5  # standard deviations
_FEWEST = 4  # crossings, for a period
_SLOW = 21  # samples; what changes over more of them is no oscillation that could be aliased


def period_of(time: FloatArray, signal: FloatArray) -> float | None:
    """The usual time in s between one rise of a signal (n,) through its mean and the next; None where it has none."""
    known = np.isfinite(signal)
    t, x = time[known], signal[known]
    if len(x) < _FEWEST or (spread := float(np.std(x))) <= _SWINGS * np.abs(x).max():
        return None
    places = rises(x, float(x.mean()), _HYSTERESIS * spread)
    return float(np.median(np.diff(t[places]))) if len(places) >= _FEWEST else None


def rises(signal: FloatArray, middle: float, band: float) -> npt.NDArray[np.intp]:
    """The places at which a signal (n,) comes to more than `band` above a `middle` from more than that below it."""
    sides = np.where(signal > middle + band, 1, np.where(signal < middle - band, -1, 0))
    outside = np.flatnonzero(sides)
    return outside[1:][np.diff(sides[outside]) > 0]


def is_aliased(signal: FloatArray) -> bool:
    """Whether a signal (n,) swings from sample to sample, with fewer than about four samples a period.

    A sine with P samples a period has the correlation cos(2 pi / P) with itself one sample later: below 0 from
    P = 4 down.
    """
    x = signal[np.isfinite(signal)]
    if len(x) < 2 * _SLOW:
        return False
    quick = x[_SLOW // 2 : -(_SLOW // 2)] - np.convolve(x, np.full(_SLOW, 1.0 / _SLOW), "valid")
    return bool(np.std(quick) > _STICKS * np.abs(x).max() and np.sum(quick[1:] * quick[:-1]) < 0.0)
