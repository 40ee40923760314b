"""Discs that lose torque to what is around them: state equations, steady rotation, energy, stability, environment."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

from drillrig_env import Friction, Rig, simulate
from drillrig_env.fleet import Fleet
from drillrig_env.model import (
    dissipated_power,
    jacobian,
    motor_power,
    state_equations,
    steady_state,
    stored_energy,
    torque_into_string,
)
from drillrig_env.scales import Scales
from drillrig_env.stability import critical_speed, eigenvalues, fold_speed, stick_slip_orbit
from drillrig_env.stability.impedance import impedance, mode_shape
from tests.rigs import scaled

pytestmark = pytest.mark.usefixtures("coarser_radau")

RIG = Rig(C_1=0.004, C_2=0.011)
TURNING = (0.0, 0.0, 2.0, 2.0, 2.0, 0.5, 0.0)


@pytest.mark.parametrize("friction", [Friction(20.0), Friction(14.0, law="linear")])
def test_runs_follow_radau(friction):
    fast, slow = (simulate(RIG, friction, TURNING, 2.0, 12.0, 0.1, method=method) for method in ("fast", "radau"))
    assert np.abs(fast.state[:, 2:5] - slow.state[:, 2:5]).max() < 1e-6


def test_jacobian_is_the_derivative_of_the_state_equations():
    x, step = np.array(TURNING) + 0.1, 1e-6
    changes = [
        (np.array(state_equations(x + step * e, 2.0, 0.1, RIG)) - state_equations(x - step * e, 2.0, 0.1, RIG))
        for e in np.eye(7)
    ]
    np.testing.assert_allclose(jacobian(RIG), np.array(changes).T / (2 * step), atol=1e-5)


def test_steady_rotation_holds_still_and_the_drive_carries_the_losses():
    rig, friction, speed = replace(RIG, T_r2=0.05), Friction(10.0), 3.0
    state, torque = steady_state(rig, friction, speed), float(friction.torque(rig, speed))
    assert np.abs(state_equations(state, speed, torque, rig)).max() < 1e-12
    assert torque_into_string(rig, state) == pytest.approx(torque + 0.05 + (0.004 + 0.011) * speed, rel=1e-12)


def test_energy_is_accounted_for():
    friction = Friction(20.0)
    run = simulate(RIG, friction, TURNING, 2.0, 8.0, 1e-3)
    power = motor_power(RIG, run.state) - dissipated_power(RIG, friction, run.state)
    stored = stored_energy(RIG, run.state)
    assert stored[-1] - stored[0] == pytest.approx(np.sum(0.5e-3 * (power[1:] + power[:-1])), abs=1e-3)
    lost = 1e-3 * np.sum(0.004 * run.bit_speed**2 + 0.011 * run.collar_speed**2)
    assert lost > 100 * 1e-3


def test_impedance_and_modes_are_those_of_the_jacobian():
    for value in eigenvalues(RIG, Friction(10.0), 2.5):
        slope = float(Friction(10.0).slope(RIG, 2.5))
        s = np.array(complex(value))
        Z, derivative = impedance(RIG, s)
        assert abs(Z + slope) < 1e-9 * abs(s * derivative)
        mode = mode_shape(RIG, s)
        np.testing.assert_allclose(jacobian(RIG, slope) @ mode, s * mode, atol=1e-8 * abs(value) * np.abs(mode).max())


def test_critical_speed_is_where_the_eigenvalues_say_and_losses_lower_it():
    friction = Friction(20.0)
    speed = critical_speed(RIG, friction)
    behind, ahead = (eigenvalues(RIG, friction, speed * k)[0].real for k in (1 - 1e-6, 1 + 1e-6))
    assert behind > 0.0 > ahead
    assert speed < critical_speed(Rig(), friction)
    assert fold_speed(RIG, friction) < fold_speed(Rig(), friction)


def test_viscous_loss_of_the_bit_is_a_slope_of_friction():
    """C_1 adds to the slope, so that the critical slope is lower by as much."""
    with_loss, without = Rig(C_1=0.003), Rig()
    slope = -0.0128
    np.testing.assert_allclose(jacobian(with_loss, slope - 0.003), jacobian(without, slope), rtol=1e-12, atol=1e-15)


def test_stick_slip_ends_at_the_fold():
    friction = Friction(20.0)
    fold = fold_speed(RIG, friction)
    start = stick_slip_orbit(RIG, friction, 0.995 * fold).state
    for share, sticks in ((0.999, True), (1.01, False)):
        run = simulate(RIG, friction, start, share * fold, 250.0, 0.05)
        assert (run.bit_speed[-200:].min() < 0.05 * fold) == sticks


def test_scale_and_time_change_no_bit_by_powers_of_two():
    torque, time = 2.0**-7, 2.0**4
    run = simulate(RIG, Friction(20.0), TURNING, 2.0, 6.0, 0.1)
    other = simulate(
        scaled(time=time, torque=torque, rig=RIG),
        Friction(20.0, v_b=time),
        np.array(TURNING) / [1, 1, time, time, time, 1, 1],
        2.0 / time,
        6.0 * time,
        0.1 * time,
    )
    np.testing.assert_array_equal(other.state[:, 2:5] * time, run.state[:, 2:5])
    assert Scales.of(scaled(time=time, torque=torque, rig=RIG), 10.0 / time).damping == Scales.of(RIG, 10.0).damping


def test_environment_reports_the_torque_with_its_losses():
    env = gym.make("DrillRig-v0", rig=RIG).unwrapped
    _, info = env.reset(seed=0, options={"start": "steady", "speed_target": 4.0, "normal_force": 5.0, "load_steps": []})
    friction = float(env.core.friction.torque(RIG, 4.0)[0])
    for _ in range(3):
        *_, info = env.step(np.zeros(1, dtype=np.float32))
    assert info["torque_into_string"] == pytest.approx(friction + 0.015 * 4.0, rel=1e-4)
    assert env.core.episodes["highest_torque"][0] == pytest.approx(friction + 0.015 * 4.0, rel=1e-4)


def test_losses_go_into_files_and_older_files_have_none(tmp_path):
    RIG.to_toml(tmp_path / "rig.toml")
    assert Rig.from_toml(tmp_path / "rig.toml") == RIG
    older = [line for line in (tmp_path / "rig.toml").read_text().splitlines() if not line.startswith("C_1")]
    (tmp_path / "older.toml").write_text("\n".join(older))
    assert Rig.from_toml(tmp_path / "older.toml") == replace(RIG, C_1=0.0)


def test_fleets_may_spread_losses_and_are_otherwise_the_same():
    plain = Fleet.around(RIG, spread={"k_2": 1.5}, count=4).members().rigs
    lossy = Fleet.around(RIG, spread={"k_2": 1.5, "C_1": 2.0}, count=4).members().rigs
    assert [rig.k_2 for rig in lossy] == [rig.k_2 for rig in plain]
    assert len({rig.C_1 for rig in lossy}) == 4
    assert all(0.5 * RIG.C_1 <= rig.C_1 <= 2.0 * RIG.C_1 for rig in lossy)


@pytest.mark.parametrize("name", ["C_1", "C_2"])
def test_impossible_losses_are_refused(name):
    with pytest.raises(ValueError, match=rf"Rig: {name} = -0.1 N m s/rad is not allowed; allowed: >= 0"):
        Rig(**{name: -0.1})
    with pytest.raises(ValueError, match="did you mean C_1"):
        Rig.of({"C1": 0.1})
