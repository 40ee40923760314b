"""Calm and mitigated at their borders, with numbers worked out by hand."""

import numpy as np
import pytest

from drillrig_env.verdict import MOVING_INDEX, is_calm, is_mitigated, stick_slip_index


@pytest.mark.parametrize("speed", [1e-6, 0.01, 0.049])
def test_standing_still_is_not_calm_however_steadily(speed):
    assert not is_calm(speed, speed, speed)
    assert not is_mitigated(speed, speed, speed, speed)


def test_slow_rotation_without_a_swing_is_calm():
    assert is_calm(0.051, 0.051, 0.051)
    assert not is_calm(-2.0, -2.0, -2.0)  # backwards is not


def test_a_swing_of_a_fifth_of_the_mean_is_the_border_of_calm():
    assert is_calm(1.8001, 2.1999, 2.0)
    assert not is_calm(1.7999, 2.2001, 2.0)


def test_mitigated_asks_for_calm_and_for_the_target():
    assert is_mitigated(2.0, 2.0, 2.0, 2.0)
    assert not is_mitigated(1.7, 2.3, 2.0, 2.0)
    assert not is_mitigated(2.0, 2.0, 2.0, 2.2)


def test_arrays_are_judged_entry_by_entry():
    lowest, highest, mean = np.array([1.9, 0.0, 0.0]), np.array([2.1, 4.0, 0.0]), np.array([2.0, 2.0, 0.0])
    assert is_calm(lowest, highest, mean).tolist() == [True, False, False]
    assert is_mitigated(lowest, highest, mean, np.array([2.0, 2.0, 2.0])).tolist() == [True, False, False]


def test_index_of_known_windows():
    """Full stick-slip is 1, a swing of +-10 % is 0.1; without a mean to refer to it is infinite."""
    assert stick_slip_index(0.0, 4.0, 2.0) == 1.0
    found = stick_slip_index(
        np.array([1.8, 0.0, -1.0, 3.0]), np.array([2.2, 0.0, 0.0, 3.0]), np.array([2.0, 0, -0.5, 3])
    )
    assert found.tolist() == pytest.approx([0.1, np.inf, np.inf, 0.0])


def test_below_the_moving_index_the_bit_never_stands_still():
    """Whatever the wave: one that touches 0 has an index of a half and more."""
    random = np.random.default_rng(1)
    waves = np.abs(random.standard_normal((500, 40))) ** random.uniform(0.05, 3.0, (500, 1))
    waves -= waves.min(axis=1, keepdims=True)  # each stands still at some time
    index = stick_slip_index(waves.min(axis=1), waves.max(axis=1), waves.mean(axis=1))
    assert index.min() >= MOVING_INDEX
    almost = 1.0 - 1e-6  # and no smaller index would do: a bit that stops for a moment only
    assert stick_slip_index(0.0, 1.0, almost) == pytest.approx(MOVING_INDEX, rel=1e-5)
    lowest, highest, mean = 1.2, 3.6, 3.0
    assert is_calm(lowest, highest, mean, index=MOVING_INDEX)
    assert not is_calm(lowest, highest, mean)
    assert is_mitigated(lowest, highest, mean, 3.1, index=MOVING_INDEX)
    assert not is_mitigated(lowest, highest, mean, 3.5, index=MOVING_INDEX)
