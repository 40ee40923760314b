"""The numbers that the chapter prints, from the same code that everything else uses."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.model import steady_state
from drillrig_env.stability import critical_slope, critical_speed
from drillrig_env.verdict import STUCK_SPEED


def swing(run, seconds=10.0):
    """Largest less smallest bit speed over the end of a run, rad/s."""
    tail = run.bit_speed[run.time > run.time[-1] - seconds]
    return np.ptp(tail)


def sticks(run, seconds=10.0):
    tail = run.bit_speed[run.time > run.time[-1] - seconds]
    return tail.min() < STUCK_SPEED and tail.max() > 1.5 * run.speed_reference[-1]


def test_critical_slope_of_4_25():
    assert round(critical_slope(Rig()), 4) == -0.0128


@pytest.mark.parametrize(("normal_force", "printed"), [(10.0, 1.994), (20.0, 2.689)])
def test_critical_speed_of_figure_4_8(normal_force, printed):
    assert critical_speed(Rig(), Friction(normal_force)) == pytest.approx(printed, abs=0.002)


def test_figure_4_7_goes_to_stick_slip_although_calm_rotation_is_locally_stable():
    friction = Friction(25.0)
    assert critical_speed(Rig(), friction) < 3.0
    stepped_on = simulate(friction=friction, speed_reference=3.0, normal_force=[(0, 0.0), (50, 25.0)], duration=200)
    assert swing(simulate(speed_reference=3.0, normal_force=0.0, duration=50)) < 0.01
    assert sticks(stepped_on)
    nearby = steady_state(Rig(), friction, 3.0) + 0.01 * np.eye(7)[2]
    assert swing(simulate(friction=friction, initial_state=nearby, speed_reference=3.0, duration=200)) < 0.01


@pytest.mark.parametrize(("speed", "vibrates"), [(2.0, True), (4.0, False)])
def test_figure_4_11(speed, vibrates):
    run = simulate(speed_reference=speed, normal_force=[(0, 0.0), (50, 20.0)], duration=150)
    assert sticks(run) if vibrates else swing(run) < 0.05


def test_slow_sweep_up_leaves_stick_slip_at_the_fold_of_figure_4_12():
    """The reference creeps up at 1e-4 rad/s^2 from 2.85 rad/s on; coarse jumps would leave p1 too early."""
    creep = np.arange(0.0, 1000.0, 0.1)
    run = simulate(
        friction=Friction(10.0),
        speed_reference=[
            (0, 2.0),
            *((60 + t, 2.0 + 0.02 * t) for t in np.arange(0, 42.5, 0.1)),
            *((102.5 + t, 2.85 + 1e-4 * t) for t in creep),
        ],
        duration=1100.0,
        sample_period=0.1,
    )
    stuck = run.time[run.bit_speed < STUCK_SPEED]
    assert run.bit_speed[-100:].min() > 2.0
    left = run.speed_reference[np.searchsorted(run.time, stuck[-1])]
    assert left == pytest.approx(2.90, abs=0.01)
