"""Speeds of encoder angles."""

import numpy as np
import pytest

from drillrig_env import Friction, simulate
from drillrig_env.calibrate.records import read_record
from drillrig_env.calibrate.records.angle import speed_of_angle

TURN = 2.0 * np.pi


@pytest.fixture(scope="module")
def motion():
    """Times, angle and speed of a bit in stick-slip, 1,000 times a second, from a run ten times as fine."""
    run = simulate(friction=Friction(25.0), speed_reference=3.14, duration=12.0, sample_period=1e-4)
    steps = 0.5e-4 * (run.bit_speed[1:] + run.bit_speed[:-1])
    angle = np.concatenate([[0.0], np.cumsum(steps)])
    return run.time[::10], angle[::10], run.bit_speed[::10]


def error(speed, true):
    return float(np.sqrt(np.nanmean((speed - true) ** 2)) / np.sqrt(np.mean(true**2)))


@pytest.mark.parametrize(
    ("rate", "steps", "allowed"),
    [
        (1000, 0, 2e-3),
        (1000, 4096, 0.02),
        (1000, 1024, 0.03),
        (1000, 100, 0.08),
        (100, 4096, 0.01),
        (50, 4096, 0.01),
        (20, 1024, 0.04),
    ],
)
def test_an_encoder_with_steps_gives_the_speed(rate, steps, allowed, motion):
    time, angle, true = (values[:: 1000 // rate] for values in motion)
    counted = np.floor(angle / (TURN / steps)) * (TURN / steps) if steps else angle
    speed, how = speed_of_angle(time, counted)
    assert error(speed, true) < allowed
    assert ("steps of" in how) == bool(steps)


def test_differences_from_sample_to_sample_would_be_ten_times_as_wrong(motion):
    time, angle, true = motion
    counted = np.floor(angle / (TURN / 1024)) * (TURN / 1024)
    assert error(speed_of_angle(time, counted)[0], true) < 0.1 * error(np.gradient(counted, time), true)


def test_an_angle_within_one_turn_goes_on(motion):
    time, angle, _ = motion
    through, _ = speed_of_angle(time, angle)
    for within in (np.mod(angle, TURN), np.mod(angle + np.pi, TURN) - np.pi):
        np.testing.assert_allclose(speed_of_angle(time, within)[0], through, atol=1e-6)


def test_glitches_missing_values_and_gaps_stay_where_they_are(motion):
    time, angle, true = (np.delete(values, slice(6000, 6500)) for values in motion)
    angle[2000] += 40.0
    angle[3000:3010] = np.nan
    speed, how = speed_of_angle(time, angle)
    assert np.flatnonzero(np.isnan(speed)).tolist() == [2000, *range(3000, 3010)]
    assert "1 samples masked as glitches" in how
    assert error(speed, true) < 3e-3


def test_uneven_sampling(motion):
    kept = np.sort(np.random.default_rng(0).choice(12001, 4000, replace=False))
    time, angle, true = (values[kept] for values in motion)
    assert error(speed_of_angle(time, angle)[0], true) < 3e-3


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("bit_angle", 1.0),
        ("bit_angle [deg]", 360.0 / TURN),
        ("Bit Encoder (counts/1024)", 1024.0 / TURN),
    ],
)
def test_a_column_of_angles_becomes_a_speed(name, factor, motion, write):
    time, angle, true = motion
    record = read_record(write(("time", name), [time, angle * factor], separator=";"))
    assert error(record.signals["bit_speed"], true) < 3e-3
    assert any(note.startswith("bit_speed: bit_angle differentiated over windows of") for note in record.notes)


def test_a_speed_that_is_measured_is_preferred(motion, write):
    time, angle, true = motion
    record = read_record(write(("time", "bit_angle", "bit_speed"), [time, angle, true]))
    np.testing.assert_allclose(record.signals["bit_speed"], true, atol=1e-6)
    assert "left out: bit_angle, as bit_speed is there" in record.notes
