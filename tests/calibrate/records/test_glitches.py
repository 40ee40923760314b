"""Glitches are masked; what a rig does is not, at any rate of sampling."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.calibrate.records.glitches import find_glitches, without_values

RATES = (5, 10, 20, 50, 100, 1000, 10000)  # Hz; the chapter's rig has periods of 2.3 s


@pytest.fixture(scope="module")
def sampled():
    """Runs of the chapter's rig by kind: rest, start, stick-slip and steady rotation, sampled 10,000 times a second."""
    inputs = {
        "stick-slip": {"normal_force": 25.0, "speed_reference": 3.14},
        "a start and a load": {"normal_force": [(0, 0.0), (6, 25.0)], "speed_reference": 3.14},
        "steps": {"normal_force": 5.0, "speed_reference": [(0, 2.0), (4, 6.0), (8, 3.0), (11, 5.0)]},
        "one slip": {"normal_force": [(0, 25.0), (4.4, 0.0)], "speed_reference": 2.0},
    }
    return {kind: simulate(**given, duration=16.0, sample_period=1e-4) for kind, given in inputs.items()}


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("kind", ["stick-slip", "a start and a load", "steps", "one slip"])
@pytest.mark.parametrize(("noise", "step"), [(0.0, 0.0), (0.02, 0.0), (0.0, 0.05), (0.1, 0.1)])
def test_what_a_rig_does_is_left_untouched(kind, rate, noise, step, sampled):
    run = sampled[kind]
    each = slice(None, None, 10000 // rate)
    rng = np.random.default_rng(rate)
    for speed in (run.bit_speed[each], run.collar_speed[each], run.top_speed[each], run.torque_into_string[each]):
        measured = speed + noise * rng.standard_normal(len(speed))
        if step:
            measured = step * np.round(measured / step)
        assert not np.any(find_glitches(run.time[each], measured))


@pytest.mark.parametrize("rate", [20, 50, 100, 1000, 10000])
def test_a_rig_with_periods_of_a_third_of_a_second_is_left_untouched(rate):
    rig = Rig(J_1=0.0006, J_2=0.0002, k_1=1.0, k_2=1.0)
    run = simulate(rig, Friction(30.0), speed_reference=5.0, duration=6.0, sample_period=1e-4)
    each = slice(None, None, 10000 // rate)
    assert not np.any(find_glitches(run.time[each], run.bit_speed[each]))


@pytest.mark.parametrize("rate", [20, 50, 100, 1000, 10000])
@pytest.mark.parametrize("kind", ["stick-slip", "steps"])
def test_glitches_are_found_and_nothing_else(kind, rate, sampled):
    run = sampled[kind]
    each = slice(None, None, 10000 // rate)
    time, speed = run.time[each], run.bit_speed[each].copy()
    rng = np.random.default_rng(rate)
    speed += 0.02 * rng.standard_normal(len(speed))
    places = np.arange(15, len(speed) - 15, max(30, len(speed) // 20))
    hit = np.zeros(len(speed), dtype=bool)
    for place in places:
        width = rng.integers(1, max(2, int(0.04 * rate)))
        hit[place : place + width] = True
        speed[place : place + width] += rng.choice([-20.0, 15.0, 40.0])
    found = find_glitches(time, speed)
    assert not np.any(found & ~hit)
    assert np.sum(found & hit) >= 0.9 * hit.sum()


def test_a_step_and_a_dropout_of_a_second_are_no_glitches():
    time = np.arange(0.0, 10.0, 0.01)
    step = np.where(time < 5.0, 1.0, 4.0)
    dropout = np.where(np.abs(time - 5.0) < 0.5, 0.0, 4.0)
    assert not np.any(find_glitches(time, step))
    assert not np.any(find_glitches(time, dropout))


def test_a_flicker_that_is_small_beside_the_motion_is_no_glitch():
    time = np.arange(0.0, 10.0, 0.01)
    speed = np.where(time < 9.0, 1e-4 * np.arange(1000.0), 4.0 * np.sin(np.pi * (time - 9.0)))
    speed[500] += 0.2
    assert not np.any(find_glitches(time, speed))


def test_missing_values_beside_a_glitch_change_nothing():
    time = np.arange(0.0, 10.0, 0.01)
    speed = 4.0 + np.sin(time)
    speed[500], speed[499], speed[502], speed[700] = 90.0, np.nan, np.nan, np.nan
    assert np.flatnonzero(find_glitches(time, speed)).tolist() == [500]


def test_what_loggers_write_for_no_value_is_none():
    signal = np.array([1.0, -999.25, np.inf, -9999.0, 1e31, np.nan, -99999.0, -9999.25, -999.0, -2.0])
    assert np.flatnonzero(np.isnan(without_values(signal))).tolist() == [1, 2, 3, 4, 5, 6, 7]
