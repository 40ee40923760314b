import gymnasium as gym
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from baselines.linear_rig import LEVEL, MEAN_TORQUE, LinearRig
from baselines.lqg import LQG
from baselines.tune import tuning_suite
from drillrig_env import Friction, Rig
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.model import frictionless_state, state_equations, steady_state, torque_into_string
from tests.baselines.episode import BISTABLE, LOAD_STEP, UNSTABLE, play


@pytest.mark.parametrize("sensors", ["state", "encoders", "surface"])
def test_frees_a_bistable_rig(sensors):
    assert play(LQG(sensors), BISTABLE)[0]["is_success"]


@pytest.mark.parametrize("sensors", ["state", "encoders", "surface"])
def test_holds_rotation_below_the_critical_speed(sensors):
    info, references = play(LQG(sensors), {**UNSTABLE, "speed_target": 2.0})
    assert info["is_success"]
    assert references[-100:].mean() == pytest.approx(2.0, rel=0.01)  # the torque does not bias the speed


@pytest.mark.parametrize("sensors", ["state", "surface"])
def test_keeps_out_under_a_load_step(sensors):
    assert play(LQG(sensors), LOAD_STEP)[0]["is_success"]


@pytest.mark.parametrize(("sensors", "accuracy"), [("state", 1e-3), ("surface", 0.05)])
def test_the_filter_finds_state_and_friction_torque_in_calm_rotation(sensors, accuracy):
    env = gym.make("DrillRig-v0", scenario="nominal", sensors=sensors)
    observation, info = env.reset(seed=0, options={"normal_force": 20.0, "speed_target": 4.0, "start": "steady"})
    policy, state = LQG(sensors), None
    for _ in range(400):
        action, state = policy.predict(observation, state)
        observation, *_, info = env.step(action)
    states, level = policy.estimate(state, np.array([info["speed_target"]]))
    rig, friction = Rig(), Friction(20.0)
    assert level[0] == pytest.approx(friction.torque(rig, 4.0), abs=accuracy)
    np.testing.assert_allclose(states[0], steady_state(rig, friction, 4.0), atol=3.0 * accuracy)


def test_the_sampled_rig_is_the_model_over_a_control_step():
    """Against SciPy's solution of (4-17), with the friction torque as the design takes it."""
    rig = Rig()
    model = LinearRig(rig, slope=0.05, forgotten=1e9)
    rng = np.random.default_rng(0)
    z, target, reference = rng.normal(0.0, 0.3, 10), 3.0, 3.4
    x = frictionless_state(rig, target) + z[:7]

    def rates(_, x):
        T_r1 = z[LEVEL] + z[8] - 0.05 * (x[2] - target)
        return [*state_equations(x[:7], reference, T_r1, rig), torque_into_string(rig, x[:7])]

    end = solve_ivp(rates, (0.0, 0.1), [*x, 0.0], method="Radau", rtol=1e-10, atol=1e-12).y[:, -1]
    after = model.transition @ z + model.input * (reference - target)
    np.testing.assert_allclose(after[:7], end[:7] - frictionless_state(rig, target), atol=1e-7)
    assert after[MEAN_TORQUE] == pytest.approx(end[7] / 0.1, abs=1e-7)


def test_the_feedback_vanishes_in_steady_rotation_and_damps_what_the_drive_cannot():
    model = LinearRig(Rig(), slope=0.08, forgotten=6.0)  # six times what the bare drive bears
    gain = model.feedback_gain(twisting=5.0, effort=10.0)
    assert gain[LEVEL] == 0.0
    z = 0.4 * model.per_level
    np.testing.assert_allclose(model.transition @ z, z, atol=1e-9)
    open_loop = np.block([[model.transition, model.input[:, None]], [np.zeros((1, 10)), np.ones((1, 1))]])
    closed = open_loop - np.outer([*model.input, 1.0], gain)
    moving = [i for i in range(11) if i != LEVEL]
    assert np.abs(np.linalg.eigvals(open_loop[np.ix_(moving, moving)])).max() > 1.05
    assert np.abs(np.linalg.eigvals(closed[np.ix_(moving, moving)])).max() < 1.0


def test_reaches_its_mark_on_random_rigs():
    """0.95 of rigs in stick-slip, told nothing; on rigs that no suite has."""
    scores = score(run(LQG(), tuning_suite("default", 150, 900_000_000)))
    assert scores["mitigated"].mean() > 0.95
    assert scores["mitigated"][scores["region"] == "below"].mean() > 0.9


def test_clear_errors():
    with pytest.raises(ValueError, match=r"LQG reads one of .*string_torque.* would do: state, encoders, surface"):
        LQG(("top_speed", "speed_reference", "speed_target"))
    with pytest.raises(ValueError, match=r"delay = 11 control steps is not allowed; allowed: 0 to 10"):
        LQG(delay=11)
