"""The fast stepper under every law of friction, against Radau with each kink as an event, and by invariants."""

import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate, simulate_batch
from drillrig_env.model import dissipated_power, motor_power, stored_energy
from tests.rigs import scaled

pytestmark = pytest.mark.usefixtures("coarser_radau")

TURNING = (0.0, 0.0, 2.0, 2.0, 2.0, 0.5, 0.0)
OTHERS = ("gaussian", "linear")


@pytest.mark.parametrize("law", OTHERS)
@pytest.mark.parametrize(
    ("force", "v_b", "speed", "start"),
    [
        (20.0, 1.0, 2.0, TURNING),  # stick-slip
        (10.0, 2.0, 3.0, None),  # calms down
        (15.0, 0.4, 2.0, TURNING),  # around the knee of the linear law, at 2.5 rad/s
        (25.0, 8.0, 0.4, None),  # falls fast: the knee is passed within a hundredth of a second
        (5.0, 2000.0, 0.3, None),  # within the stick zone
    ],
)
def test_laws_are_followed_within_the_tolerance(law, force, v_b, speed, start):
    friction = Friction(force, v_b=v_b, law=law)
    fast, slow = (simulate(None, friction, start, speed, 6.0, 0.1, method=method) for method in ("fast", "radau"))
    assert np.abs(fast.state[:, 2:5] - slow.state[:, 2:5]).max() < 1e-6


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("push", [0.3, -0.3])
def test_a_run_may_begin_at_the_very_kink_of_a_law(sign, push):
    """Just at 1 / v_b a step belongs to the piece that it goes into, and at omega_s likewise."""
    for v_b, x_3 in ((2.0, 0.5), (3.0, Rig().omega_s)):
        start = sign * np.array([push, 0.0, x_3, x_3, x_3, 0.0, 0.0])
        friction = Friction(10.0, v_b=v_b, law="linear")
        fast, slow = (simulate(None, friction, start, 0.5, 1.0, 0.05, method=method) for method in ("fast", "radau"))
        assert np.abs(fast.state[:, 2:5] - slow.state[:, 2:5]).max() < 1e-6


@pytest.mark.parametrize("law", OTHERS)
def test_friction_without_a_fall_is_the_same_under_every_law(law):
    for friction in (Friction(20.0, 0.4, 0.4), Friction(20.0, v_b=1e-7), Friction(0.0)):
        chapters = simulate(None, friction, TURNING, 2.0, 5.0, 0.1)
        other = simulate(None, Friction(*friction.as_array()[0], law=law), TURNING, 2.0, 5.0, 0.1)
        np.testing.assert_allclose(other.state, chapters.state, atol=1e-5)


@pytest.mark.parametrize("law", OTHERS)
def test_scale_and_time_change_no_bit_by_powers_of_two(law):
    torque, time = 2.0**9, 2.0**-3
    start = np.array(TURNING)
    run = simulate(None, Friction(20.0, v_b=0.7, law=law), start, 2.0, 6.0, 0.1)
    other = simulate(
        scaled(time=time, torque=torque),
        Friction(20.0, v_b=0.7 * time, law=law),
        start / [1, 1, time, time, time, 1, 1],
        2.0 / time,
        6.0 * time,
        0.1 * time,
    )
    np.testing.assert_array_equal(other.state[:, 2:5] * time, run.state[:, 2:5])


@pytest.mark.parametrize("law", OTHERS)
def test_energy_is_accounted_for(law):
    rig, friction = Rig(), Friction(20.0, law=law)
    run = simulate(rig, friction, TURNING, 2.0, 8.0, 1e-3)
    power = motor_power(rig, run.state) - dissipated_power(rig, friction, run.state)
    gained = np.sum(0.5e-3 * (power[1:] + power[:-1]))
    stored = stored_energy(rig, run.state)
    assert stored[-1] - stored[0] == pytest.approx(gained, abs=1e-3)


def test_batch_of_a_law_comes_out_as_its_rigs_one_at_a_time():
    friction = Friction(np.array([5.0, 15.0, 30.0]), v_b=np.array([0.5, 1.0, 2.0]), law="linear")
    batch = simulate_batch(None, friction, TURNING, 2.0, 5.0)
    for states, one in zip(batch, friction.each(), strict=True):
        np.testing.assert_array_equal(states, simulate(None, one, TURNING, 2.0, 5.0, 0.1).state)
