"""Intervals at 95 %: Wilson's for rates, bootstrap for means and differences, over rigs or over training seeds.

Episodes of a fleet are no independent draws where several have the same rig: what is drawn anew there are the rigs,
each with all of its episodes (`over_rigs`).

Wilson: J. Am. Stat. Assoc. 22, 1927; bootstrap: Efron, Ann. Statist. 7, 1979; interquartile mean: Agarwal et al.,
NeurIPS 2021.

>>> import numpy as np
>>> from drillrig_env.evaluation.statistics import difference, mean, median, over_rigs, over_seeds, rate
>>> mitigated = np.array([True] * 18 + [False] * 2)
>>> share = rate(mitigated)
>>> round(share.value, 2), round(share.low, 2), round(share.high, 2)
(0.9, 0.7, 0.97)
>>> seconds = np.array([6.0, 7.0, 7.5, 8.0, 9.0, 60.0])
>>> median(seconds).value, round(mean(seconds).value, 2)
(7.75, 16.25)
>>> difference(mitigated, np.zeros(20, dtype=bool)).value
0.9
>>> over_rigs(mitigated, np.arange(20) // 4).count, over_seeds([0.91, 0.97, 0.99], count=1000).count
(20, 1000)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

_RESAMPLES = 2000
_SEED = 20_240_601  # of the resampling, so that a table comes out the same twice
_MANY, _NORMAL = 10_000, 1.959963984540054  # values; the 97.5 % quantile of the normal distribution
_TRIMMED = 0.25  # share cut off at either end: what is left is the interquartile mean


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval, from `count` episodes; NaN where there was nothing to estimate from.

    The interval is from `low` to `high`.
    """

    value: float
    low: float
    high: float
    count: int


def rate(outcomes: npt.NDArray[np.bool_]) -> Estimate:
    """Share of true outcomes, with Wilson's interval."""
    count = len(outcomes)
    if count == 0:
        return Estimate(np.nan, np.nan, np.nan, 0)
    hits = int(np.count_nonzero(outcomes))
    interval = stats.binomtest(hits, count).proportion_ci(method="wilson")
    return Estimate(hits / count, float(interval.low), float(interval.high), count)


def mean(values: npt.NDArray[np.float64]) -> Estimate:
    """Mean, with the percentile bootstrap's interval (2,000 resamples from a fixed seed).

    Of more than 10,000 values it is the interval of a normal distribution, which the bootstrap's comes to.
    """
    values = np.asarray(values, dtype=float)
    if len(values) <= _MANY or not np.isfinite(values).all():
        return _bootstrapped(values, np.mean)
    found, away = float(np.mean(values)), _NORMAL * float(np.std(values, ddof=1)) / np.sqrt(len(values))
    return Estimate(found, found - away, found + away, len(values))


def median(values: npt.NDArray[np.float64]) -> Estimate:
    """Median, with the percentile bootstrap's interval (2,000 resamples from a fixed seed).

    Of more than 10,000 values it is the interval between the two of them whose ranks hold the median of what they are
    drawn from (a binomial distribution of ranks), which the bootstrap's comes to.
    """
    values = np.asarray(values, dtype=float)
    if len(values) <= _MANY or not np.isfinite(values).all():
        return _bootstrapped(values, np.median)
    away = 0.5 * _NORMAL * np.sqrt(len(values))
    low, high = int(np.floor(0.5 * len(values) - away)), int(np.ceil(0.5 * len(values) + away))
    ordered = np.partition(values, (low, high))
    return Estimate(float(np.median(values)), float(ordered[low]), float(ordered[high]), len(values))


def difference(values: npt.NDArray[Any], reference: npt.NDArray[Any]) -> Estimate:
    """Mean of `values` less `reference` on the same rigs, with the bootstrap's interval over rigs.

    Both are scores or outcomes with one entry a rig. What the rigs have in common cancels, so the
    interval is narrower than that of two separate means. `ValueError` for unequal lengths.
    """
    if np.shape(values) != np.shape(reference):
        raise ValueError(f"paired differences of {np.shape(values)} and {np.shape(reference)} values; allowed: equal")
    return mean(np.asarray(values, dtype=float) - np.asarray(reference, dtype=float))


def over_rigs(
    values: npt.NDArray[Any], rigs: npt.NDArray[np.intp], statistic: Callable[..., Estimate] = rate
) -> Estimate:
    """`rate`, `mean` or `median` of values (n,) of episodes with the rigs `rigs` (n,), its interval over the rigs.

    `statistic` is one of the three.

    Rigs are drawn anew with all of their episodes (2,000 resamples from a fixed seed).
    """
    values = np.asarray(values, dtype=float)
    names, rigs = np.unique(rigs, return_inverse=True)
    if len(names) < 2:
        return statistic(values)
    times = _times_drawn(len(names))
    if statistic is median:
        order = np.argsort(values, kind="stable")
        reached = (np.cumsum(row[rigs[order]]) for row in times)  # one by one: together they may be large
        middle = [np.searchsorted(row, (row[-1] + 1) // 2) for row in reached]
        found, resampled = np.median(values), values[order][middle]
    else:
        sums, counts = np.bincount(rigs, values), np.bincount(rigs)
        found, resampled = values.mean(), (times @ sums) / (times @ counts)
    low, high = np.quantile(resampled, (0.025, 0.975))
    return Estimate(float(found), float(low), float(high), len(values))


@lru_cache(maxsize=8)
def _times_drawn(rigs: int) -> npt.NDArray[np.intp]:
    """How often each of some rigs is drawn in each resample; shape (_RESAMPLES, rigs)."""
    drawn = np.random.default_rng(_SEED).integers(rigs, size=(_RESAMPLES, rigs))
    return np.stack([np.bincount(row, minlength=rigs) for row in drawn])


def over_seeds(values: Sequence[float] | npt.NDArray[np.float64], count: int) -> Estimate:
    """Interquartile mean over training seeds, one value a seed, with the bootstrap's interval over seeds.

    A quarter of the seeds is cut off at either end (rounded down) and the rest is averaged. `count`
    is the number of episodes behind all values together. With few seeds the interval is rough.
    """
    seeds = np.asarray(values, dtype=float)
    found = _bootstrapped(seeds, interquartile_mean)
    return Estimate(found.value, found.low, found.high, count)


def interquartile_mean(values: npt.NDArray[np.float64], axis: int = -1) -> Any:
    """Mean of the middle half of the values along an axis.

    >>> import numpy as np
    >>> round(float(interquartile_mean(np.array([0.1, 0.9, 0.92, 0.95, 0.97, 0.99, 1.0, 1.0]))), 3)
    0.958
    """
    return stats.trim_mean(values, _TRIMMED, axis=axis)


def _bootstrapped(values: npt.NDArray[np.float64], statistic: Callable[..., Any]) -> Estimate:
    count = len(values)
    if count == 0:
        return Estimate(np.nan, np.nan, np.nan, 0)
    if np.all(values == values[0]) or not np.isfinite(values).all():
        value = float(values[0] if np.all(values == values[0]) else statistic(values))
        return Estimate(value, value, value, count)
    interval = stats.bootstrap(
        (values,), statistic, n_resamples=_RESAMPLES, method="percentile", rng=np.random.default_rng(_SEED)
    ).confidence_interval
    return Estimate(float(statistic(values)), float(interval.low), float(interval.high), count)
