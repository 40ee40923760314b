"""Intervals: Wilson's for rates, bootstrap for means; both at 95 %."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

_RESAMPLES = 2000
_SEED = 20_240_601  # of the resampling, so that a table comes out the same twice


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval; NaN where there was nothing to estimate from."""

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
    """Mean, with the percentile bootstrap's interval (2,000 resamples from a fixed seed)."""
    return _bootstrapped(np.asarray(values, dtype=float), np.mean)


def median(values: npt.NDArray[np.float64]) -> Estimate:
    """Median, with the percentile bootstrap's interval (2,000 resamples from a fixed seed)."""
    return _bootstrapped(np.asarray(values, dtype=float), np.median)


def _bootstrapped(values: npt.NDArray[np.float64], statistic: Callable[..., Any]) -> Estimate:
    count = len(values)
    if count < 2 or np.ptp(values) == 0.0:
        value = float(statistic(values)) if count else np.nan
        return Estimate(value, value, value, count)
    interval = stats.bootstrap(
        (values,), statistic, n_resamples=_RESAMPLES, method="percentile", rng=np.random.default_rng(_SEED)
    ).confidence_interval
    return Estimate(float(statistic(values)), float(interval.low), float(interval.high), count)
