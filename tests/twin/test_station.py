"""One client has the rig at a time, and where its commands do not come the watchdog has it."""

import math

import pytest

from drillrig_env.twin.channel import Wire
from drillrig_env.twin.rig import PARTS, SimulatedRig
from drillrig_env.twin.station import ARMED, IDLE, TRIPPED, Station

ME, OTHER = object(), object()


@pytest.fixture
def station():
    return Station(SimulatedRig(options={"start": "steady", "speed_target": 3.0}))


def control_step(station):
    return [message for _ in range(PARTS) for message in station.advance()]


def test_nobody_commands_at_first(station):
    for _ in range(20):
        (message,) = control_step(station)
        assert (message["reference"], message["state"], message["taken"]) == (3.0, IDLE, 0)
    with pytest.raises(ValueError, match="command without the rig; arm first"):
        station.command(ME, 2.0)


def test_commands_act_from_the_next_part_on(station):
    station.arm(ME)
    assert station.rig.reference == 3.0
    for k in range(1, 6):
        station.command(ME, 3.0 + 0.1 * k)
        (message,) = control_step(station)
        assert (message["reference"], message["taken"], message["state"]) == (3.0 + 0.1 * k, k, ARMED)
    with pytest.raises(ValueError, match="another client has the rig"):
        station.arm(OTHER)
    with pytest.raises(ValueError, match="command without the rig"):
        station.command(OTHER, 1.0)
    station.release(OTHER)  # has no effect
    assert station.state == ARMED
    station.release(ME)
    control_step(station)
    assert (station.state, station.rig.reference) == (IDLE, 3.5)
    station.arm(OTHER)
    assert station.rig.reference == 3.5


def test_silence_trips_the_watchdog_and_another_may_have_the_rig(station):
    station.arm(ME)
    station.command(ME, 2.9)
    for _ in range(4):
        control_step(station)
    assert (station.state, station.rig.reference) == (TRIPPED, pytest.approx(2.9, abs=0.06))
    for _ in range(60):
        control_step(station)
    assert station.rig.reference == 1.0
    station.command(ME, 2.0)  # too late
    control_step(station)
    assert station.rig.reference == 1.0
    station.arm(OTHER)
    assert station.state == ARMED
    with pytest.raises(ValueError, match="without the rig"):
        station.command(ME, 2.0)


def test_commands_of_the_former_client_do_not_act_for_the_next():
    station = Station(SimulatedRig(options={"start": "steady", "speed_target": 3.0}), Wire(latency=0.15))
    station.arm(ME)
    station.command(ME, 9.0)
    station.release(ME)
    station.arm(OTHER)
    for _ in range(3):
        control_step(station)
    assert station.rig.reference == 3.0


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -1.0, 99.0, None, "2", True, [2.0], {}, 10**400, "\ud800"])
def test_a_command_that_cannot_be_is_none_and_told_once(station, wrong):
    station.arm(ME)
    for _ in range(3):
        station.command(ME, wrong)
        control_step(station)
    assert station.rig.reference == 3.0
    assert [event.kind for event in station.events.kept] == ["armed", "refused"]
    assert str(station.events.kept[1]).isascii()  # it can be printed anywhere
    control_step(station)
    assert station.state == TRIPPED


def test_a_flood_of_commands_is_refused(station):
    station.arm(ME)
    for _ in range(100):
        station.command(ME, 3.0)
    with pytest.raises(ValueError, match="100 commands are underway already"):
        station.command(ME, 3.0)
    control_step(station)
    station.command(ME, 3.0)


def test_measurements_and_commands_are_lost_apart():
    station, came, taken = Station(SimulatedRig(), Wire(loss=0.5), periods=100), [], []
    station.arm(ME)
    for _ in range(40):
        before = station.taken
        station.command(ME, station.rig.reference)
        came.append(len(control_step(station)))
        taken.append(station.taken - before)
    assert set(came) == set(taken) == {0, 1}
    assert came != taken


def test_late_measurements_tell_their_own_time():
    station = Station(SimulatedRig(), Wire(latency=0.25))
    times = [(station.time, message["time"]) for _ in range(50) for message in station.advance()]
    assert all(arrived - taken == pytest.approx(0.26) for arrived, taken in times)  # at the end of a part
    assert len(times) == 7


def test_scales_are_the_rigs():
    other = Station(SimulatedRig(rig="field_2500m"))
    scales = other.rig.usual.scales
    assert other.watchdog.fallback_speed == pytest.approx(scales.speed)
    assert other.watchdog.ramp == pytest.approx(0.5 * scales.rate)
    assert other.watchdog.highest == other.rig.usual.largest_reference
    assert other.watchdog.period == other.rig.period
