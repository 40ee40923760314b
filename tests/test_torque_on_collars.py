"""A torque T_r2 on a disc 2 that keeps turning, all the way: stepper, samples, observations, energy, controllers.

`tests/stepper/test_modes.py` has what happens where it sticks or turns backwards.
"""

from dataclasses import replace

import numpy as np
import pytest

from baselines import make
from drillrig_env import Friction, Rig, simulate
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite
from drillrig_env.model import (
    dissipated_power,
    frictionless_state,
    motor_power,
    steady_state,
    stored_energy,
    torque_into_string,
    wound_up,
)
from drillrig_env.stepper.ladder import SAMPLES

pytestmark = pytest.mark.usefixtures("coarser_radau")

RIG, WITHOUT = Rig(T_r2=0.1), Rig()


def begun(rig, start, force=20.0, target=2.0, **arguments):
    core = EpisodeBatch(1, rig=rig, scenario="nominal", **arguments)
    pins = {"normal_force": force, "speed_target": target, "start": start}
    core.reset(np.array([0]), first_uniforms(0, 1), pins)
    return core


@pytest.mark.parametrize(("force", "speed"), [(10.0, 2.0), (10.0, 6.0), (30.0, 0.5)])
def test_fast_stepper_agrees_with_radau(force, speed):
    arguments = {"friction": Friction(force), "speed_reference": speed, "duration": 5.0, "sample_period": 0.05}
    fast, exact = (simulate(RIG, method=method, **arguments) for method in ("fast", "radau"))
    np.testing.assert_allclose(fast.state[:, 2:5], exact.state[:, 2:5], atol=1e-6)
    np.testing.assert_allclose(fast.torque_into_string, exact.torque_into_string, atol=1e-6)


def test_torque_samples_of_a_control_step_lie_on_the_radau_solution():
    core = begun(RIG, "stick_slip")
    exact = simulate(
        RIG, Friction(20.0), core.episodes["state"][0, :7].copy(), 2.0, 1.0, sample_period=0.1 / SAMPLES, method="radau"
    )
    for torque in exact.torque_into_string[1:].reshape(-1, SAMPLES):
        core.step(np.zeros((1, 1), dtype=np.float32))
        record = core.episodes[0]
        found = [record[name] for name in ("string_torque", "highest_torque", "torque_into_string")]
        np.testing.assert_allclose(found, [torque.mean(), torque.max(), torque[-1]], atol=1e-6)
        assert record["torque_into_string"] == pytest.approx(torque_into_string(RIG, record["state"][:7]), abs=1e-12)


@pytest.mark.parametrize("speed", [0.5, 3.0])
def test_steady_rotation_carries_both_torques(speed):
    friction = Friction(10.0)
    torque = friction.torque(RIG, speed) + RIG.T_r2
    assert torque_into_string(RIG, steady_state(RIG, friction, speed)) == pytest.approx(torque, rel=1e-12)
    assert torque_into_string(RIG, frictionless_state(RIG, speed)) == pytest.approx(RIG.T_r2, rel=1e-12)


def test_wound_up_rig_carries_both_torques_and_is_about_to_break_loose():
    states = wound_up(RIG, Friction(20.0), 2.0)
    static = 20.0 * RIG.r_1 * 0.5
    assert -RIG.k_1 * states[0] == pytest.approx(static)
    assert -RIG.k_2 * states[1] == pytest.approx(static + RIG.T_r2)


def test_what_is_seen_of_the_torque_stays_level_in_steady_rotation():
    core = begun(RIG, "steady", force=10.0, target=4.0, sensors="surface", noise=0.0)
    expected = Friction(10.0).torque(RIG, 4.0) + RIG.T_r2
    for _ in range(30):
        core.step(np.zeros((1, 1), dtype=np.float32))
        seen = core.sensors.values(core.observations)
        for name in ("string_torque", "string_torque_mean"):
            np.testing.assert_allclose(seen[name], expected, atol=1e-6)
        np.testing.assert_allclose(seen["string_torque_deviation"], 0.0, atol=1e-6)


def test_energy_that_goes_in_is_stored_or_lost():
    friction = Friction(10.0)
    run = simulate(RIG, friction, speed_reference=2.0, duration=10.0, sample_period=5e-4)
    assert run.bit_speed[run.time > 5].min() < 1e-3  # it sticks

    def integral(power):  # Simpson's rule
        return (power[0] + power[-1] + 4 * power[1:-1:2].sum() + 2 * power[2:-1:2].sum()) * 5e-4 / 3

    work = integral(motor_power(RIG, run.state))
    lost = integral(dissipated_power(RIG, friction, run.state))
    begin, end = stored_energy(RIG, run.state)[[0, -1]]
    assert integral(RIG.T_r2 * run.collar_speed) > 0.05 * work
    assert abs(work - lost - (end - begin)) < 1e-6 * work


@pytest.mark.parametrize("sensors", ["state", "surface"])
@pytest.mark.parametrize("policy", ["lqg", "feed_forward_start", "z_torque", "soft_torque", "speed_pulse"])
def test_controllers_do_with_it_as_they_do_without(policy, sensors):
    """The motion is the same but for a constant twist and current: one who knows of T_r2 allows for it."""
    chosen = suite("default", 24)
    light = replace(chosen.scenario, normal_force=(3.0, 6.0), speed_target=(2.5, 5.0))  # disc 2 keeps turning
    chosen = replace(chosen, scenario=light)
    with_it, without = (
        run(make(policy, sensors=sensors, rig=rig), chosen, rig=rig, sensors=sensors) for rig in (RIG, WITHOUT)
    )
    apart = np.abs(with_it.speed_reference - without.speed_reference).max(axis=1)
    assert np.quantile(apart, 0.9) < 1e-3  # rounding may turn a decision in one rig or another
    torque = with_it.torque_into_string - without.torque_into_string
    np.testing.assert_allclose(torque[apart < 1e-6], RIG.T_r2, atol=1e-4)
    assert abs(sum(score(with_it)["mitigated"]) - sum(score(without)["mitigated"])) <= 1
