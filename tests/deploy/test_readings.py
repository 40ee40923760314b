"""The latest measurements, and how old they are, whatever the clocks of both sides say."""

import pytest

from drillrig_env.deploy.readings import Readings


def message(time, state="armed", **more):
    return {"time": time, "values": {"current": time}, "reference": 2.0, "state": state, **more}


def test_ages_count_from_the_fastest_message():
    readings = Readings("rig")
    assert readings.ages(5.0) == {}
    with pytest.raises(ConnectionError, match="rig sends no measurements"):
        readings.seen()
    readings.take(message(1.0), clock=1001.02)
    assert readings.ages(1001.02) == {"current": pytest.approx(0.0)}
    readings.take(message(1.1), clock=1001.10)  # 0.02 s faster than the first
    assert readings.ages(1001.15) == {"current": pytest.approx(0.05)}
    readings.take(message(1.2, ages={"current": 0.5}), clock=1001.30)  # 0.1 s late, and old before
    assert readings.ages(1001.30) == {"current": pytest.approx(0.6)}


def test_a_clock_that_jumps_is_got_over():
    readings = Readings("rig")
    for k in range(200):
        jump = 3.0 if k >= 100 else 0.0  # the rig's clock stood still for 3 s
        readings.take(message(0.1 * k), clock=0.1 * k + jump)
        age = readings.ages(0.1 * k + jump)["current"]
        assert age == pytest.approx(3.0 if 100 <= k < 120 else 0.0) or 120 <= k < 152
    for k in range(200, 300):  # and what grows slower and slower is old
        readings.take(message(0.1 * k), clock=0.12 * k + jump)
    assert readings.ages(0.12 * k + jump)["current"] > 0.4


def test_what_was_overtaken_is_passed_over():
    readings = Readings("rig", same_clock=True)
    readings.take(message(1.1), 1.2)
    assert readings.fresh
    assert readings.seen() == {"current": 1.1}
    readings.take(message(1.0), 1.2)
    assert not readings.fresh
    assert readings.values == {"current": 1.1}
    assert readings.ages(1.25) == {"current": pytest.approx(0.15)}
    readings.take(message(1.2), 1.3)
    assert readings.fresh


def test_a_watchdog_that_took_over_since_is_told():
    readings = Readings("rig")
    readings.take(message(1.0, "tripped"), 1.0)
    readings.armed_at = 1.05
    readings.take(message(1.05, "tripped"), 1.1)  # from before
    with pytest.raises(ConnectionError, match="the watchdog of rig has taken over; it waits to be armed again"):
        readings.take(message(1.1, "tripped"), 1.1)


@pytest.mark.parametrize(
    "wrong", [{"time": "now"}, {"values": [1.0]}, {"reference": None}, {"ages": 3.0}, {"time": []}]
)
def test_what_is_no_message_is_an_error(wrong):
    with pytest.raises((TypeError, ValueError)):
        Readings("rig").take({**message(1.0), **wrong}, 1.0)
