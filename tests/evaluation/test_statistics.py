import numpy as np
import pytest

from drillrig_env.evaluation import statistics
from drillrig_env.evaluation.statistics import difference, interquartile_mean, mean, median, over_seeds, rate


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
    assert mean(np.array([3.0])) == mean(np.array([])).__class__(3.0, 3.0, 3.0, 1)
    assert np.isnan(rate(np.array([], dtype=bool)).value)
    assert np.isnan(mean(np.array([])).value)


def test_paired_difference_is_that_of_the_means_with_the_interval_of_the_differences():
    rng = np.random.default_rng(1)
    rigs = rng.normal(0.0, 10.0, 400)  # what the rigs have in common
    gain = rng.normal(1.0, 0.5, 400)
    found = difference(rigs + gain, rigs)
    half = 1.96 * gain.std(ddof=1) / 20
    assert found.value == pytest.approx(gain.mean())
    assert (found.low, found.high) == pytest.approx((gain.mean() - half, gain.mean() + half), abs=0.1 * half)


def test_difference_of_rates_has_the_standard_error_of_paired_outcomes():
    ours, theirs = np.zeros(400, dtype=bool), np.zeros(400, dtype=bool)
    ours[:120], theirs[80:140] = True, True  # 80 won, 20 lost: McNemar's discordant pairs
    found = difference(ours, theirs)
    error = np.sqrt((80 + 20) - (80 - 20) ** 2 / 400) / 400
    assert found.value == pytest.approx(60 / 400)
    assert (found.high - found.low) / 2 == pytest.approx(1.96 * error, rel=0.08)


def test_equal_policies_differ_by_nothing_and_other_rigs_are_refused():
    values = np.arange(5.0)
    assert difference(values, values) == mean(np.zeros(5))
    with pytest.raises(ValueError, match="allowed: equal"):
        difference(values, values[:4])


def test_interquartile_mean_of_five_seeds_is_the_mean_of_the_middle_three():
    found = over_seeds([0.1, 0.9, 0.91, 0.95, 0.2], 5000)
    assert found.value == pytest.approx((0.2 + 0.9 + 0.91) / 3)
    assert found.count == 5000
    assert 0.1 <= found.low < found.value < found.high <= 0.95
    assert interquartile_mean(np.arange(8.0)) == pytest.approx(np.mean([2, 3, 4, 5]))


def test_one_seed_and_equal_seeds_have_no_interval():
    assert over_seeds([0.7], 1000) == over_seeds([0.7, 0.7, 0.7], 1000)


def test_values_without_bound_have_no_interval_and_warn_of_nothing():
    """Indices of rigs that stand still are infinite: a median can bear some of them, a mean cannot."""
    values = np.array([1.0, 2.0, 3.0, np.inf, np.inf])
    with np.errstate(all="raise"):
        assert vars(median(values)) == {"value": 3.0, "low": 3.0, "high": 3.0, "count": 5}
        assert mean(values).value == mean(values).low == mean(values).high == np.inf
        assert median(np.full(4, np.inf)).value == np.inf
    unknown = mean(np.array([1.0, np.nan, 2.0]))
    assert np.isnan([unknown.value, unknown.low, unknown.high]).all()
    assert unknown.count == 3


def test_median_and_mean_differ_on_a_skewed_sample():
    values = np.array([1.0] * 60 + [2.0] * 30 + [50.0] * 10)
    middle, average = median(values), mean(values)
    assert (middle.value, average.value) == (1.0, pytest.approx(6.2))
    assert middle.low <= 1.0 <= middle.high <= 2.0
    assert 3.0 < average.low < 6.2 < average.high < 10.0
    assert (middle.count, average.count) == (100, 100)


def test_many_values_have_the_intervals_that_the_bootstrap_comes_to(monkeypatch):
    values = np.random.default_rng(3).exponential(size=4000)
    for statistic in (mean, median):
        drawn = statistic(values)
        with monkeypatch.context() as patch:
            patch.setattr(statistics, "_MANY", 3999)
            reckoned = statistic(values)
        assert reckoned != drawn
        assert (reckoned.value, reckoned.count) == (pytest.approx(drawn.value), 4000)
        width = drawn.high - drawn.low
        assert reckoned.low == pytest.approx(drawn.low, abs=0.1 * width)
        assert reckoned.high == pytest.approx(drawn.high, abs=0.1 * width)


def test_many_values_that_are_not_finite_have_no_interval(monkeypatch):
    monkeypatch.setattr(statistics, "_MANY", 2)
    found = mean(np.array([1.0, np.inf, 2.0]))
    assert (found.value, found.low, found.high) == (np.inf, np.inf, np.inf)
