import numpy as np
import pytest

from drillrig_env.evaluation.statistics import mean, median, rate


def test_wilson_interval_in_closed_form():
    z, n, p = 1.959963984540054, 50, 0.9
    centre = (p + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    estimate = rate(np.arange(50) < 45)
    assert (estimate.value, estimate.count) == (0.9, 50)
    assert (estimate.low, estimate.high) == pytest.approx((centre - half, centre + half))


def test_all_or_nothing_keeps_an_interval():
    assert rate(np.ones(10, dtype=bool)).low < 1.0
    assert rate(np.zeros(10, dtype=bool)).high > 0.0


def test_bootstrap_of_a_mean_is_near_the_normal_interval():
    values = np.random.default_rng(0).normal(3.0, 2.0, 400)
    estimate = mean(values)
    half = 1.96 * values.std(ddof=1) / 20
    assert estimate.value == values.mean()
    assert (estimate.low, estimate.high) == pytest.approx(
        (estimate.value - half, estimate.value + half), abs=0.1 * half
    )
    assert mean(values) == estimate


def test_constant_and_empty_samples():
    assert median(np.full(5, 7.0)) == median(np.full(9, 7.0)).__class__(7.0, 7.0, 7.0, 5)
    assert np.isnan(rate(np.array([], dtype=bool)).value)
    assert np.isnan(mean(np.array([])).value)
