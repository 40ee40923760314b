"""Where commands stop coming the rig's side comes down by itself, and waits."""

import math
from itertools import pairwise

import pytest

from drillrig_env.deploy import Supervisor, Watchdog, run_loop
from drillrig_env.twin.dry_run import DryRig, Instant


def test_three_silent_periods_end_in_a_ramp():
    dog = Watchdog(period=0.1, fallback_speed=1.0, highest=10.0, ramp=0.5)
    dog.arm(2.0, 0.0)
    for k in range(1, 11):
        assert dog.command(2.0 + 0.1 * k, 0.1 * k)
        assert dog.reference(0.1 * k) == 2.0 + 0.1 * k
    assert dog.reference(1.3) == 3.0  # three periods: not over
    assert not dog.tripped
    assert dog.reference(1.5) == pytest.approx(3.0 - 0.5 * 0.2)
    assert dog.tripped
    assert dog.reference(10.0) == 1.0
    assert not dog.command(2.0, 10.1)  # until it is armed again
    assert dog.reference(10.1) == 1.0
    dog.arm(1.0, 10.2)
    assert dog.command(1.2, 10.3)
    assert dog.reference(10.3) == 1.2
    assert [event.kind for event in dog.events.kept] == ["armed", "watchdog", "armed"]
    assert "no command for 0.5 s, over 3 periods; to 1 rad/s" in dog.events.kept[1].reason


def test_a_command_that_comes_too_late_is_not_taken():
    dog = Watchdog(period=0.1, fallback_speed=1.0, highest=10.0)
    dog.arm(2.0, 0.0)
    assert not dog.command(3.0, 0.35)
    assert dog.tripped


def test_it_never_raises_the_speed_by_itself():
    dog = Watchdog(period=0.1, fallback_speed=1.0, highest=10.0)
    dog.arm(0.4, 0.0)
    assert dog.reference(5.0) == 0.4


def test_what_is_given_back_in_order_stays_as_it_is():
    dog = Watchdog(period=0.1, fallback_speed=1.0, highest=10.0)
    dog.arm(3.0, 0.0)
    dog.release(0.1)
    assert not dog.command(5.0, 0.2)
    assert dog.reference(60.0) == 3.0
    assert [event.kind for event in dog.events.kept] == ["armed", "released"]
    dog.arm(3.0, 61.0)
    dog.release(70.0)  # too late: it has taken over
    assert [event.kind for event in dog.events.kept][2:] == ["armed", "watchdog"]
    assert dog.reference(80.0) == 1.0


def test_of_a_row_of_impossible_commands_the_first_is_told():
    dog = Watchdog(period=0.1, fallback_speed=1.0, highest=10.0)
    dog.arm(2.0, 0.0)
    for command in (math.nan, 99.0, 2.0, True):
        dog.command(command, 0.1)
    assert [event.kind for event in dog.events.kept] == ["armed", "refused", "refused"]


@pytest.mark.parametrize("command", [math.nan, math.inf, -0.1, 10.1, None, "3", True, 10**400, "\ud800"])
def test_impossible_commands_are_none(command):
    dog = Watchdog(period=0.1, fallback_speed=1.0, highest=10.0)
    dog.arm(2.0, 0.0)
    assert not dog.command(command, 0.1)
    assert dog.reference(0.2) == 2.0
    assert dog.events.kept[-1].kind == "refused"
    dog.reference(0.4)
    assert dog.tripped


def test_it_does_nothing_before_it_is_armed():
    dog = Watchdog(period=0.1, fallback_speed=1.0, highest=10.0)
    assert dog.reference(0.0) == 0.0
    assert not dog.command(2.0, 0.1)
    with pytest.raises(ValueError, match="period = 0 s is not allowed"):
        Watchdog(period=0, fallback_speed=1.0, highest=10.0)


def test_a_loop_that_dies_leaves_the_rig_to_its_watchdog():
    """The computer of the policy fails after 3 s; the rig's own goes on, and comes down by itself."""
    pytest.importorskip("onnxruntime")
    clock, rig = Instant(), DryRig(3)
    dog = Watchdog(period=0.1, fallback_speed=1.0, highest=10.0)
    dog.arm(rig.reference, clock())

    class Line:
        def measure(self):
            if rig.steps == 30:
                raise ConnectionError("the instruments are gone")
            return rig.measure()

        def command(self, speed_reference):
            assert dog.command(speed_reference, clock())
            rig.command(dog.reference(clock()))

    supervisor = Supervisor("lqg")
    with pytest.raises(ConnectionError):
        run_loop(
            supervisor, Line(), reference=rig.reference, target=3.0, steps=100, clock=clock, sleep=clock.sleep
        )  # fmt: skip
    last, seen = dog.reference(clock()), []
    for _ in range(100):
        clock.sleep(0.1)
        rig.command(dog.reference(clock()))
        seen.append(rig.reference)
    assert not math.isclose(last, 1.0)
    assert seen[:2] == pytest.approx([last, last])
    assert seen[-1] == pytest.approx(1.0)
    assert max(abs(b - a) for a, b in pairwise(seen)) <= 0.05 + 1e-6
