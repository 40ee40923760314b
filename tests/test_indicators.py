import numpy as np
import pytest
from scipy.stats import pearsonr

from drillrig_env.indicators import (
    UndefinedIndicatorError,
    amplitude_pulse_level,
    correlation,
    score_signals,
    score_table,
)


def printed_correlation(x_1, x_2):
    """(4-10) term by term, with sums over the n points."""
    n = len(x_1)
    above = (x_1 * x_2).sum() - x_1.sum() * x_2.sum() / n
    below = ((x_1**2).sum() - x_1.sum() ** 2 / n) * ((x_2**2).sum() - x_2.sum() ** 2 / n)
    return above / np.sqrt(below)


@pytest.fixture
def signals():
    x_1, noise = np.random.default_rng(0).normal(3.0, 1.0, (2, 500))
    return x_1, 0.6 * x_1 + noise


def test_correlation_is_the_printed_formula(signals):
    assert correlation(*signals) == pytest.approx(printed_correlation(*signals), rel=1e-12)
    assert correlation(*signals) == pytest.approx(pearsonr(*signals).statistic, rel=1e-12)
    assert 0.3 < correlation(*signals) < 0.7


def test_correlation_is_blind_to_scale_and_offset(signals):
    x_1, x_2 = signals
    assert correlation(x_1, 5.0 + 2.0 * x_1) == pytest.approx(1.0)
    assert correlation(x_1, -x_1) == pytest.approx(-1.0)
    assert correlation(x_1, 100.0 + 3.0 * x_2) == pytest.approx(correlation(x_1, x_2))


@pytest.mark.parametrize(
    ("measured", "simulated", "level"),
    [([0.0, 4.0], [5.0, 0.0], 0.25), ([0.0, 4.0], [0.0, 1.0], 0.75), ([-2.0, -4.0], [-3.0, -5.0], 0.5)],
)
def test_amplitude_pulse_level_is_the_printed_formula(measured, simulated, level):
    assert amplitude_pulse_level(measured, simulated) == level


def test_perfect_match(signals):
    assert correlation(signals[0], signals[0]) == pytest.approx(1.0, abs=1e-12)
    assert amplitude_pulse_level(signals[0], signals[0]) == 0.0


@pytest.mark.parametrize("indicator", [correlation, amplitude_pulse_level])
@pytest.mark.parametrize(
    ("measured", "simulated", "words"),
    [
        ([1.0, 2.0], [1.0, 2.0, 3.0], ["(2,)", "(3,)", "same"]),
        ([1.0], [2.0], ["(1,)", "n >= 2"]),
        ([[1.0, 2.0]], [[1.0, 2.0]], ["(1, 2)", "(n,)"]),
        ([1.0, np.nan, 2.0], [1.0, 2.0, 3.0], ["measured[1] = nan", "finite"]),
        ([1.0, 2.0], [np.inf, 2.0], ["simulated[0] = inf", "finite"]),
    ],
)
def test_signals_that_do_not_go_together_are_refused(indicator, measured, simulated, words):
    with pytest.raises(ValueError, match=indicator.__name__) as caught:
        indicator(measured, simulated)
    assert not isinstance(caught.value, UndefinedIndicatorError)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(("constant", "moving"), [("measured", "simulated"), ("simulated", "measured")])
@pytest.mark.parametrize("values", [[0.0, 0.0, 0.0], [3.0, 3.0, 3.0 + 1e-12]])
def test_constant_signal_has_no_correlation(constant, moving, values):
    with pytest.raises(UndefinedIndicatorError, match=f"the {constant} signal is constant"):
        correlation(**{constant: values, moving: [1.0, 2.0, 4.0]})


def test_no_pulse_has_no_level():
    with pytest.raises(UndefinedIndicatorError, match=r"max\(measured\) is 0"):
        amplitude_pulse_level([-1.0, 0.0], [1.0, 2.0])


def test_window_and_whole_file_are_scored_apart():
    time = np.arange(21.0)
    measured = np.sin(time)
    simulated = np.where(time <= 10.0, measured, -2.0 * measured)
    early, whole = score_signals(time, {"bit_speed": measured}, {"bit_speed": simulated})
    assert (early.signal, early.part, early.samples) == ("bit_speed", "first 10 s", 11)
    assert (early.correlation, early.amplitude_pulse_level) == (pytest.approx(1.0), 0.0)
    assert (whole.part, whole.samples) == ("whole file", 21)
    assert whole.correlation == correlation(measured, simulated) < 0.0
    assert whole.amplitude_pulse_level == amplitude_pulse_level(measured, simulated) > 0.5


def test_signal_without_indicator_does_not_spoil_the_others():
    moving, still = np.array([1.0, 2.0, 3.0]), np.zeros(3)
    scores = score_signals(
        np.arange(3.0), {"bit_speed": still, "top_speed": moving}, {"bit_speed": moving, "top_speed": moving}
    )
    assert np.isnan([[s.correlation, s.amplitude_pulse_level] for s in scores]).all(axis=1).tolist() == [1, 1, 0, 0]
    lines = score_table(scores).splitlines()
    assert lines[1].split() == ["bit_speed", "first", "10", "s", "3", "undefined", "undefined"]
    assert lines[3].split() == ["top_speed", "first", "10", "s", "3", "1.000", "0.000"]
    assert lines[5].startswith("undefined: ")


@pytest.mark.parametrize("window", [0.5, -1.0, float("nan")])
def test_window_without_samples_is_refused(window):
    with pytest.raises(ValueError, match=rf"window = {window} s .* >= 1 s"):
        score_signals(np.arange(3.0), {"bit_speed": np.arange(3.0)}, {"bit_speed": np.arange(3.0)}, window)
