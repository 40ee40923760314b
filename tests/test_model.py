import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.model import (
    check_state,
    dissipated_power,
    friction_input,
    frictionless_state,
    jacobian,
    minimum_speed,
    motor_power,
    state_equations,
    steady_state,
    stored_energy,
    torque_into_string,
    wound_up,
)

RIG = Rig()
RIGS = [RIG, Rig(T_r2=0.05, k_p=1.5, eta=6.0)]


def rates(x, omega_ref, rig, friction):
    return np.array(state_equations(x, omega_ref, friction.torque(rig, x[2]), rig))


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("bit_speed", [3e-4, 1.5, -2.0])
def test_jacobian_4_19_is_the_derivative_of_4_17(rig, bit_speed):
    friction = Friction(12.0)
    x = np.array([0.2, -0.5, bit_speed, 1.1, 2.0, 0.7, 3.0])
    columns = [
        (rates(x + step, 2.0, rig, friction) - rates(x - step, 2.0, rig, friction)) / 2e-7 for step in 1e-7 * np.eye(7)
    ]
    slope = friction.slope(rig, bit_speed)
    np.testing.assert_allclose(jacobian(rig, slope), np.stack(columns, axis=1), rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("rig", RIGS)
def test_steady_state_4_16_stands_still(rig):
    friction = Friction(np.array([5.0, 20.0, 40.0]))
    states = steady_state(rig, friction, np.array([1.0, 2.0, 8.0]))
    for x, speed, force in zip(states, (1.0, 2.0, 8.0), (5.0, 20.0, 40.0), strict=True):
        np.testing.assert_allclose(rates(x, speed, rig, Friction(force)), 0.0, atol=1e-9)


def test_minimum_speed_4_15():
    assert minimum_speed(RIG, Friction(np.array([10.0, 20.0]))) == pytest.approx([0.1309, 0.1573], abs=5e-5)
    with pytest.raises(ValueError, match="k_p = 0"):
        minimum_speed(Rig(k_p=0.0), Friction())


def simpson(values, step):
    return (values[0] + values[-1] + 4 * values[1:-1:2].sum() + 2 * values[2:-1:2].sum()) * step / 3


@pytest.mark.parametrize("rig", [RIG, Rig(T_r2=0.05)])
def test_energy_balance_closes_along_stick_slip(rig):
    friction = Friction(18.0)  # so that disc 2 keeps turning forwards, against T_r2
    run = simulate(rig, friction, speed_reference=2.5, duration=20.0, sample_period=5e-4)
    assert run.bit_speed[run.time > 10].min() < 1e-3  # it sticks
    work = simpson(motor_power(rig, run.state), 5e-4)
    lost = simpson(dissipated_power(rig, friction, run.state), 5e-4)
    stored = stored_energy(rig, run.state)[[0, -1]]
    assert work > 1.0
    assert abs(work - lost - (stored[1] - stored[0])) < 1e-6 * work


def test_friction_enters_the_rates_as_its_input_says():
    x = [0.2, -0.5, 1.0, 1.1, 2.0, 0.7, 3.0]
    added = np.subtract(state_equations(x, 2.0, 0.75, RIG), state_equations(x, 2.0, 0.25, RIG))
    np.testing.assert_allclose(friction_input(RIG) * 0.5, added, atol=1e-12)
    assert np.flatnonzero(added).tolist() == [2]


@pytest.mark.parametrize("rig", RIGS)
def test_frictionless_state_stands_still_without_a_bit_that_rubs(rig):
    np.testing.assert_allclose(state_equations(frictionless_state(rig, 3.0), 3.0, 0.0, rig), 0.0, atol=1e-9)
    torque_on_disc_2 = np.array(state_equations(frictionless_state(rig, 0.0), 0.0, 0.0, rig)) * rig.J_2
    np.testing.assert_allclose(torque_on_disc_2, np.eye(7)[3] * rig.T_r2, atol=1e-9)  # what dry friction holds
    assert frictionless_state(rig, np.zeros((2, 3))).shape == (2, 3, 7)


@pytest.mark.parametrize("rig", [*RIGS, Rig(T_r2=0.3)])
def test_wound_up_rig_holds_still_at_the_torque_of_break_loose(rig):
    """Stand the motor still as well: then both discs are in balance under the largest static torque, N_1 r_1 mu_s."""
    friction = Friction(np.array([5.0, 20.0]), mu_s=0.6)
    states = wound_up(rig, friction, 2.0)
    assert states.shape == (2, 7)
    for x, force in zip(states, (5.0, 20.0), strict=True):
        assert x[2:5].tolist() == [0.0, 0.0, 2.0]
        still = [*x[:4], 0.0, *x[5:]]
        forces = np.array(state_equations(still, 2.0, force * rig.r_1 * 0.6, rig)) * [0, 0, rig.J_1, rig.J_2, 0, 0, 0]
        np.testing.assert_allclose(forces, np.eye(7)[3] * rig.T_r2, atol=1e-12)  # what dry friction holds
    np.testing.assert_allclose(states[:, 5:], steady_state(rig, friction, 2.0)[:, 5:])


def test_wound_up_rig_breaks_loose_and_a_hair_less_does_not():
    friction = Friction(20.0)
    x = wound_up(RIG, friction, 2.0)
    loose = simulate(None, friction, x, 2.0, duration=0.2)
    assert loose.bit_speed.max() > 0.05
    x[:2] *= 0.8
    held = simulate(None, friction, x, 2.0, duration=0.1)
    assert np.abs(held.bit_speed).max() < 1e-3


def test_torque_into_string_is_what_accelerates_the_motor_less_what_drives_it():
    """(4-5e): J_3 x_5' = eta K_T x_6 - eta^2 C_m x_5 - eta T_f - T."""
    x = np.array([0.2, -0.5, 1.0, 1.1, 2.0, 0.7, 3.0])
    net = RIG.J_3 * state_equations(x, 2.0, 0.3, RIG)[4]
    driven = RIG.eta * RIG.K_T * x[5] - RIG.eta**2 * RIG.C_m * x[4] - RIG.eta * RIG.T_f
    assert torque_into_string(RIG, x) == pytest.approx(driven - net)
    assert torque_into_string(RIG, np.stack([x, 2 * x])) == pytest.approx(torque_into_string(RIG, x) * np.array([1, 2]))


def test_powers_and_energy_of_a_state_by_hand():
    rig = Rig(T_r2=0.05)
    x = np.array([0.2, -0.5, 1.0, 1.5, 2.0, 0.7, 3.0])
    assert stored_energy(rig, x) == pytest.approx(
        0.5 * (0.0288 * 1.0 + 0.0149 * 2.25 + 0.0237 * 4.0 + 1.1175 * 0.04 + 0.3659 * 0.25)
    )
    assert motor_power(rig, x) == pytest.approx(8.0 * 0.126 * 0.7 * 2.0)
    torque = 10.0 * 0.0485 * (0.306 + 0.194 * np.exp(-1.0))
    lost = 0.0202 * 0.25 + 0.0167 * 0.25 + 64.0 * 1.784e-4 * 4.0 + 8.0 * 0.1196 * 2.0 + 0.05 * 1.5 + torque
    assert dissipated_power(rig, Friction(10.0), x) == pytest.approx(lost)


def test_a_state_is_checked_and_copied():
    np.testing.assert_array_equal(check_state(RIG, None), frictionless_state(RIG, 0.0))
    given = np.ones(7)
    assert check_state(RIG, given) is not given
    assert check_state(RIG, np.ones((3, 7))).shape == (3, 7)
    for wrong in (np.ones(6), np.ones((2, 3, 7)), 1.0):
        with pytest.raises(ValueError, match="initial_state: shape"):
            check_state(RIG, wrong)
    given[5] = np.nan
    with pytest.raises(ValueError, match="initial_state: current = nan A"):
        check_state(RIG, given)
