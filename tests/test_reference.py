"""The two SciPy solutions that the stepper is tested against, where the answer is known in closed form."""

import numpy as np
import pytest
from scipy.linalg import expm

from drillrig_env import Friction, Rig
from drillrig_env.model import frictionless_state, jacobian, steady_state
from drillrig_env.reference import radau, vode

RIG = Rig(T_r2=0.05)
START = np.array([0.2, -0.5, 1.0, 1.1, 2.0, 0.7, 3.0])


@pytest.mark.parametrize(("solve", "accuracy"), [(vode, 1e-5), (radau, 1e-8)])
def test_free_rig_is_the_matrix_exponential(solve, accuracy):
    times = np.array([0.0, 0.05, 0.11, 0.2])
    rest = frictionless_state(RIG, 2.0)
    expected = [rest + expm(jacobian(RIG) * t) @ (START - rest) for t in times[1:]]
    found = solve(RIG, Friction(0.0), 2.0, START, times)
    assert found.shape == (3, 7)
    np.testing.assert_allclose(found, expected, atol=accuracy)


@pytest.mark.parametrize("solve", [vode, radau])
def test_steady_rotation_stays_and_time_may_begin_anywhere(solve):
    state = steady_state(RIG, Friction(10.0), 3.0)
    found = solve(RIG, Friction(10.0), 3.0, state, np.array([5.0, 5.05, 5.2]))
    np.testing.assert_allclose(found, np.stack([state, state]), atol=1e-6)


def test_stuck_bit_is_the_linear_rig_with_the_slope_of_the_stick_zone():
    """Inside the stick zone (4-9) is linear: an event-split solution is a matrix exponential there, too."""
    friction = Friction(20.0)
    rig, times = Rig(), np.array([0.0, 0.02, 0.1])
    start = frictionless_state(rig, 0.0)
    slope = 20.0 * 0.0485 * 0.5 / 1e-3
    matrix, rest = jacobian(rig, slope), frictionless_state(rig, 0.0)
    drift = jacobian(rig) @ (rest - frictionless_state(rig, 0.5))  # the reference of 0.5 rad/s winds it up
    expected = [rest + np.linalg.solve(matrix, (expm(matrix * t) - np.eye(7)) @ drift) for t in times[1:]]
    np.testing.assert_allclose(radau(rig, friction, 0.5, start, times), expected, atol=1e-8)


def test_kinks_are_met_from_both_sides_and_backwards():
    """A bit that slips forwards, sticks, and is let go backwards; the two methods agree after all of it."""
    rig = Rig(T_f=0.0)
    start = np.array([0.5, 0.9, 0.3, 0.0, 0.0, 0.0, 0.0])
    times = np.array([0.0, 0.05, 0.3, 0.5])
    split, plain = (solve(rig, Friction(8.0), 0.0, start, times) for solve in (radau, vode))
    assert split[0, 2] > -0.5
    assert split[1:, 2].min() < -0.05
    np.testing.assert_allclose(split, plain, atol=3e-5)
