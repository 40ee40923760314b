import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.model import (
    dissipated_power,
    jacobian,
    minimum_speed,
    motor_power,
    state_equations,
    steady_state,
    stored_energy,
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


def test_energy_balance_closes_along_stick_slip():
    friction = Friction(20.0)
    run = simulate(friction=friction, speed_reference=2.0, duration=20.0, sample_period=5e-4)
    assert run.bit_speed[run.time > 10].min() < 1e-3  # it sticks

    def integral(power):  # Simpson's rule
        return (power[0] + power[-1] + 4 * power[1:-1:2].sum() + 2 * power[2:-1:2].sum()) * 5e-4 / 3

    work = integral(motor_power(RIG, run.state))
    lost = integral(dissipated_power(RIG, friction, run.state))
    stored = stored_energy(RIG, run.state)[[0, -1]]
    assert work > 1.0
    assert abs(work - lost - (stored[1] - stored[0])) < 1e-6 * work
