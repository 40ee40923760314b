"""The sampled linear rig: what its channels show, and that filter and feedback are the optimal ones."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from baselines.linear_rig import (
    FLUCTUATION,
    LEVEL,
    MEAN_TORQUE,
    MEASURED,
    SIZE,
    LinearRig,
    applied,
    gain_of,
    without_friction,
)
from drillrig_env import Rig
from drillrig_env.model import STATE_NAMES, frictionless_state, state_equations, torque_into_string

RIGS = [Rig(), Rig(T_r2=0.1, k_p=2.0, k_i=0.7)]
MODEL = LinearRig(Rig(), slope=0.02, forgotten=4.0)
Z = np.array([0.1, -0.2, 0.5, 0.3, -0.4, 0.2, 0.6, 0.35, -0.05, 0.3])


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("channel", MEASURED)
def test_a_measurement_and_what_it_shows_without_friction_add_up_to_the_channel(rig, channel):
    """At a speed reference of 3.4 about a target of 3 rad/s."""
    model = LinearRig(rig, slope=0.02, forgotten=4.0)
    row, through = model.measurement(channel)
    x = frictionless_state(rig, 3.0) + Z[:7]
    steady = torque_into_string(rig, frictionless_state(rig, 3.0))
    values = dict(zip(STATE_NAMES, x, strict=True))
    values["voltage"] = rig.k_p * (3.4 - x[4]) + rig.k_i * x[6]
    values["string_torque"] = steady + Z[MEAN_TORQUE]
    plain = without_friction(rig, rig, channel, np.array(3.0))
    assert row @ Z + through * 0.4 + plain == pytest.approx(values[channel])


def test_the_torque_that_a_drive_takes_for_that_of_the_nominal_rig():
    """Over a control step of Radau's: eta K_T mean i - eta^2 C_m mean x_5 - eta T_f - J_3 dx_5 / h with its numbers."""
    nominal, rig = Rig(), Rig(J_3=0.04, K_T=0.12, C_m=3e-4, T_f=0.13, k_2=0.5)
    model, target, reference = LinearRig(rig, 0.05, 1e9, 0.1, nominal), 3.0, 3.4
    x = frictionless_state(rig, target) + Z[:7]

    def rates(_, x):
        T_r1 = Z[LEVEL] + Z[FLUCTUATION] - 0.05 * (x[2] - target)
        return [*state_equations(x[:7], reference, T_r1, rig), x[4], x[5]]

    end = solve_ivp(rates, (0.0, 0.1), [*x, 0.0, 0.0], "Radau", rtol=1e-10, atol=1e-12).y[:, -1]
    speed, current = end[7:] / 0.1
    torque = nominal.eta * nominal.K_T * current - nominal.eta**2 * nominal.C_m * speed - nominal.eta * nominal.T_f
    torque -= nominal.J_3 * (end[4] - x[4]) / 0.1
    after = model.transition @ Z + model.input * (reference - target)
    shown = after[MEAN_TORQUE] + without_friction(rig, nominal, "string_torque", np.array(target))
    assert shown == pytest.approx(torque, abs=1e-7)
    z = 0.4 * model.per_level  # and steady rotation under more friction shows as much more
    np.testing.assert_allclose(model.transition @ z, z, atol=1e-9)


@pytest.mark.parametrize("rig", RIGS)
def test_steady_rotation_under_a_level_of_friction_goes_on(rig):
    """z grows with T_0 as the rig's own equations say: state and friction torque hold still together."""
    model = LinearRig(rig, slope=0.05, forgotten=4.0)
    z = 0.4 * model.per_level
    np.testing.assert_allclose(model.transition @ z, z, atol=1e-9)
    x = frictionless_state(rig, 2.5) + z[:7]
    np.testing.assert_allclose(state_equations(x, 2.5, 0.4, rig), 0.0, atol=1e-9)
    assert z[MEAN_TORQUE] == pytest.approx(
        torque_into_string(rig, x) - torque_into_string(rig, frictionless_state(rig, 2.5))
    )
    np.testing.assert_allclose(frictionless_state(rig, 4.0) + 1.5 * model.per_speed, frictionless_state(rig, 5.5))


def test_fluctuations_are_forgotten_and_the_level_is_not():
    z = np.zeros(SIZE)
    z[LEVEL] = z[FLUCTUATION] = 1.0
    for _ in range(40):
        z = MODEL.transition @ z
    assert z[LEVEL] == 1.0
    assert z[FLUCTUATION] == pytest.approx(np.exp(-1.0))  # 4 s, as long as `forgotten`


def test_filter_brings_the_error_of_its_estimate_down():
    """Error (1 - gain rows) transition: all of it dies but the level's leak, for full and for poor sensors."""
    for channels, noise in ((STATE_NAMES, np.full(7, 0.02)), (("string_torque", "top_speed"), np.array([0.02, 0.02]))):
        gain = MODEL.filter_gain(channels, noise, level=0.05, fluctuation=0.05)
        rows = np.stack([MODEL.measurement(name)[0] for name in channels])
        assert gain.shape == (SIZE, len(channels))
        error = (np.eye(SIZE) - gain @ rows) @ MODEL.transition
        assert np.abs(np.linalg.eigvals(error)).max() < 1.0


def test_filter_trusts_good_channels_more_and_follows_a_restless_level_faster():
    sharp, dull = (MODEL.filter_gain(("bit_speed", "twist_12"), np.array([0.01, n]), 0.05, 0.05) for n in (0.005, 0.5))
    assert abs(sharp[0, 1]) > 5 * abs(dull[0, 1])
    calm, restless = (
        MODEL.filter_gain(("string_torque", "top_speed"), np.full(2, 0.02), level, 0.02) for level in (0.005, 0.2)
    )
    assert restless[LEVEL, 0] > 2 * calm[LEVEL, 0] > 0.0


def test_gain_of_is_the_least_squares_update():
    """One scalar state known within 2, measured within 1: the estimate moves by 4 / 5."""
    assert gain_of(np.array([[4.0]]), np.array([[1.0]]), np.array([[1.0]])) == pytest.approx(np.array([[0.8]]))
    covariance, rows, noise = np.diag([1.0, 4.0]), np.array([[1.0, 2.0]]), np.array([[3.0]])
    np.testing.assert_allclose(gain_of(covariance, rows, noise), np.array([[1.0], [8.0]]) / 20.0)


def test_feedback_is_the_least_of_its_cost_among_its_neighbours():
    """Cost of 400 steps from an error of the states, summed: any change of the gain makes it dearer."""
    twisting, effort = 5.0, 10.0
    gain = MODEL.feedback_gain(twisting, effort)
    assert gain.shape == (SIZE + 1,)
    assert gain[LEVEL] == gain[MEAN_TORQUE] == 0.0

    def cost(gain):
        z, r, total = np.array([*Z[:7], 0.0, 0.1, 0.0]), 0.2, 0.0
        for _ in range(400):
            change = -gain @ np.append(z, r)
            total += z[2] ** 2 + twisting * (z[3] - z[4]) ** 2 + effort * change**2
            r += change
            z = MODEL.transition @ z + MODEL.input * r
        return total

    best = cost(gain)
    for i in (0, 2, 4, 6, 8, 10):
        for size in (0.02, -0.02, 3e-4, -3e-4):
            other = gain.copy()
            other[i] += size * np.abs(gain).max()
            assert cost(other) > best


def test_products_are_the_same_to_the_last_bit_in_company():
    matrix, vectors = np.random.default_rng(0).normal(size=(4, 10)), np.random.default_rng(1).normal(size=(50, 10))
    together = applied(matrix, vectors)
    np.testing.assert_array_equal(together[17], applied(matrix, vectors[17:18])[0])
    np.testing.assert_allclose(together, vectors @ matrix.T)
