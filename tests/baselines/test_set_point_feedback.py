"""The feedback at a set-point, against the Riccati equation at that very friction slope and against the model."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import solve_discrete_are

from baselines.set_point_feedback import SIZE, SetPointFeedback, _sampled, wanted_change
from drillrig_env import Friction, Rig
from drillrig_env.model import state_equations, steady_state
from drillrig_env.scales import CONTROL_PERIOD
from drillrig_env.stability import critical_slope

RIG, EFFORT = Rig(), 3.0
FEEDBACK = SetPointFeedback([RIG], EFFORT)


def of_slope(slope):
    """A friction that has this slope (N m s/rad, negative) at 2 rad/s."""
    return Friction(-slope * np.exp(2.0) / (RIG.r_1 * 0.194))


def exact_gain(slope):
    transition, by_change = _sampled(RIG, slope, CONTROL_PERIOD)
    cost = 1e-6 * np.eye(SIZE)
    cost[2, 2] = 1.0
    price = solve_discrete_are(transition, by_change, cost, np.array([[EFFORT]]))
    return (by_change.T @ price @ transition / (EFFORT + by_change.T @ price @ by_change))[0]


@pytest.mark.parametrize("share", [0.0, 0.013, 0.31, 0.9, 2.27, 5.8, 40.0, 63.9])
def test_gain_between_the_entries_of_the_table_is_that_of_the_slope(share):
    slope = share * critical_slope(RIG)
    found = FEEDBACK.at(of_slope(slope), np.array([2.0]))[0, :SIZE]
    exact = exact_gain(slope)
    np.testing.assert_allclose(found, exact, atol=2e-4 * np.abs(exact).max())


def test_gain_has_no_steps_between_neighbouring_slopes():
    slopes = np.linspace(0.9, 1.1, 2001) * critical_slope(RIG)
    gains = FEEDBACK.at(of_slope(slopes), np.full(2001, 2.0))[:, :SIZE]
    change = np.abs(np.diff(gains, axis=0)).max(axis=0)
    assert np.all(change <= 3.0 * np.ptp(gains, axis=0) / 2000 + 1e-12)


def test_steeper_friction_than_the_table_knows_gets_its_last_gain():
    steep, steeper = (FEEDBACK.at(of_slope(k * critical_slope(RIG)), np.array([2.0]))[0, :SIZE] for k in (64.0, 500.0))
    np.testing.assert_allclose(steep, steeper)
    np.testing.assert_allclose(steep, FEEDBACK.tables[0, -1])


def test_no_change_is_wanted_in_steady_rotation_at_the_set_point_and_the_right_one_elsewhere():
    friction, speeds = Friction(np.array([5.0, 20.0, 30.0]), v_b=1.1), np.array([1.0, 2.5, 6.0])
    feedback, states = FEEDBACK.at(friction, speeds), steady_state(RIG, friction, speeds)
    np.testing.assert_allclose(wanted_change(feedback, states, speeds), 0.0, atol=1e-9)
    z = np.linspace(-0.3, 0.4, SIZE)
    moved = wanted_change(feedback, states + z[:7], speeds + z[7])
    np.testing.assert_allclose(moved, -feedback[:, :SIZE] @ z, atol=1e-9)


def test_shapes_of_set_points_and_frictions_broadcast():
    found = FEEDBACK.at(Friction(np.array([5.0, 10.0, 20.0])), np.full((4, 3), 2.0))
    assert found.shape == (4, 3, SIZE + 1)
    np.testing.assert_array_equal(found[0], found[3])
    np.testing.assert_allclose(found[2, 1], FEEDBACK.at(Friction(10.0), np.array([2.0]))[0])


@pytest.mark.parametrize("share", [0.5, 4.0, 40.0])
def test_holds_rotation_that_the_bare_drive_cannot(share):
    """The sampled rig with the feedback is stable, at 4 and 40 times the slope where the bare drive gives in."""
    slope = share * critical_slope(RIG)
    transition, by_change = _sampled(RIG, slope, CONTROL_PERIOD)
    gain = FEEDBACK.at(of_slope(slope), np.array([2.0]))[0, :SIZE]
    closed = np.abs(np.linalg.eigvals(transition - by_change @ gain[None]))
    bare = np.abs(np.linalg.eigvals(transition[:7, :7]))
    assert closed.max() < 1.0
    assert (bare.max() > 1.0) == (share > 1.0)


def test_sampled_model_is_the_rig_over_a_control_step():
    slope, z, change = -0.05, np.linspace(-0.2, 0.3, SIZE), 0.15
    steady = np.array([*np.zeros(2), 2.0, 2.0, 2.0, 0.0, 0.0])
    base = state_equations(steady, 2.0, 0.0, RIG)

    def rates(_, x):
        moved = state_equations(steady + x, 2.0 + z[7] + change, slope * x[2], RIG)
        return np.subtract(moved, base)

    end = solve_ivp(rates, (0.0, 0.1), z[:7], method="Radau", rtol=1e-10, atol=1e-12).y[:, -1]
    transition, by_change = _sampled(RIG, slope, CONTROL_PERIOD)
    np.testing.assert_allclose((transition @ z + by_change[:, 0] * change)[:7], end, atol=1e-8)
    assert (transition @ z + by_change[:, 0] * change)[7] == pytest.approx(z[7] + change)


def test_each_rig_of_several_has_its_own_feedback():
    other = Rig(J_1=0.02, k_2=0.5, K_T=0.13)
    both, places = SetPointFeedback([RIG, other], EFFORT, entries=41), np.array([1, 0, 1])
    friction, speeds = Friction(np.array([8.0, 20.0, 30.0])), np.array([2.0, 3.0, 1.5])
    found = both.at(friction, speeds, places)
    for k, rig in ((0, other), (1, RIG), (2, other)):
        alone = SetPointFeedback([rig], EFFORT).at(Friction(friction.normal_force[k]), speeds[k : k + 1])[0]
        np.testing.assert_allclose(found[k], alone, atol=5e-3 * np.abs(alone).max())  # from fewer entries
