import gymnasium as gym
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from baselines.linear_rig import LEVEL, MEAN_TORQUE, LinearRig, without_friction
from baselines.lqg import _FIRST_LEVEL_SPREAD, _FIRST_SPREAD, LQG, OFFSET, PAST, SHAKING, SLOPES, STEP
from baselines.tune import tuning_suite
from drillrig_env import Friction, Rig
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.model import frictionless_state, state_equations, steady_state, torque_into_string
from drillrig_env.stability import critical_slope
from tests.baselines.episode import BISTABLE, LOAD_STEP, UNSTABLE, play
from tests.rigs import FIELD

ONLY = np.zeros(1, dtype=int)
"""The place of the one rig among the rigs of a policy that is not told any."""

MODEL = LinearRig(Rig(), slope=SLOPES[0], forgotten=6.0)


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


def test_estimates_are_in_the_units_of_the_rig():
    policy, target = LQG("state", rig=FIELD), 9.0
    memory = np.zeros((1, policy.memory))
    memory[0, LEVEL] = 2.0
    states, level = policy.estimate((memory,), np.array([target]))
    assert policy.unit("string_torque") > 100.0
    assert level[0] == pytest.approx(2.0 * policy.unit("string_torque"), rel=1e-12)
    np.testing.assert_allclose(states[0], frictionless_state(FIELD, target), rtol=1e-9)


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


def test_moving_the_set_point_moves_the_origin_and_nothing_else():
    """States, friction torque and past references that the memory stands for are the same before and after."""
    policy = LQG(delay=3)
    rng = np.random.default_rng(2)
    memory, set_point = rng.normal(0.0, 0.3, (4, policy.memory)), np.array([3.0, 4.0, 5.0, 3.5])
    memory[:, STEP], memory[:, OFFSET], memory[:, SHAKING] = 80.0, [1.0, 0.5, 2.0, 0.0], [4.0, 0.0, 0.0, 4.0]
    gains, before = np.array([3, 10, 20, 30]), memory.copy()
    move = policy._move_set_point(memory[:, :10].copy(), memory, set_point, gains, ONLY)
    assert (move != 0).all()
    rig, at = Rig(), set_point + move
    states = [frictionless_state(rig, s) + m[:, :7] for s, m in ((set_point, before), (at, memory))]
    np.testing.assert_allclose(states[1], states[0], atol=1e-12)
    torque = [
        m[:, LEVEL] - SLOPES[gains] * (x[:, 2] - s)
        for s, m, x in ((set_point, before, states[0]), (at, memory, states[1]))
    ]
    np.testing.assert_allclose(torque[1], torque[0], atol=1e-12)
    past = slice(PAST, PAST + 4)
    np.testing.assert_allclose(at[:, None] + memory[:, past], set_point[:, None] + before[:, past], atol=1e-12)
    np.testing.assert_allclose(memory[:, OFFSET] - before[:, OFFSET], move)


@pytest.mark.parametrize(
    ("shaking", "offset", "steps", "move"),
    [
        (0.39, 1.0, 80, 0.2),  # it shakes: up at 2 rad/s^2
        (0.37, 1.0, 80, -0.0952),  # it does not: down at 0.952 rad/s^2
        (0.37, 0.03, 80, -0.03),  # no further than the target
        (0.39, 1.0, 29, 0.0),  # no verdict before 3 s
        (0.39, 1.0, 30, 0.2),
        (0.39, 4.9, 80, 0.1),  # room for the feedback below 10 rad/s
        (0.39, 5.5, 80, 0.0),
    ],
)
def test_set_point_rises_while_it_shakes_and_comes_down_to_the_target(shaking, offset, steps, move):
    policy = LQG()
    memory = np.zeros((1, policy.memory))
    set_point = np.array([3.0 + offset])
    memory[0, OFFSET], memory[0, STEP], memory[0, SHAKING] = offset, steps, (shaking * set_point[0]) ** 2
    gains = np.array([0])
    assert policy._move_set_point(np.zeros((1, 10)), memory, set_point, gains, ONLY)[0] == pytest.approx(move)


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_estimate_of_late_measurements_is_reckoned_on_with_the_known_references(delay):
    """Until the second measurement arrives all that moves the estimate is the model and what was commanded."""
    policy = LQG(delay=delay)
    model, target, gains = MODEL, np.array([3.0]), np.array([0])
    rng = np.random.default_rng(4)
    references = rng.normal(0.0, 0.5, 12)
    first = {
        name: np.array([value]) for name, value in zip(policy.sensors.names, rng.normal(1.0, 0.3, 12), strict=False)
    }
    memory = np.zeros((1, policy.memory))
    z = expected = policy._estimate(first, memory, target, references[:1], gains, ONLY)[0]
    for step in range(1, delay + 1):
        expected = model.transition @ expected + model.input * references[step]
        z = policy._estimate(first, memory, target, references[step : step + 1], gains, ONLY)[0]
        np.testing.assert_allclose(z, expected, atol=1e-10)
    # From then on measurements that are just what the model says leave the reckoning as it is.
    true = [policy._estimate(first, np.zeros((1, policy.memory)), target, references[:1], gains, ONLY)[0]]
    for reference in references[1:]:
        true.append(model.transition @ true[-1] + model.input * reference)
    for step in range(delay + 1, 12):
        at = step - delay
        shown = {
            name: model.measurement(name)[0] @ true[at]
            + model.measurement(name)[1] * references[at]
            + without_friction(Rig(), Rig(), name, target)
            for name in policy.measured
        }
        z = policy._estimate(shown, memory, target, references[step : step + 1], gains, ONLY)[0]
        np.testing.assert_allclose(z, true[step], atol=1e-9)


def test_error_of_the_first_estimate_has_nothing_in_common_with_what_was_seen():
    """The mark of the best linear estimate, here with the ordinary noise of the surface and what is known before."""
    policy = LQG("surface")
    known = np.diag([*np.square(_FIRST_SPREAD), 0.0, 0.0, 0.01])
    known += _FIRST_LEVEL_SPREAD**2 * np.outer(MODEL.per_level, MODEL.per_level)
    noise = {channel.name: channel.noise for channel in policy.sensors.channels}
    rows = np.stack([MODEL.measurement(name)[0] for name in policy.measured])
    seen = rows @ known @ rows.T + np.diag([noise[name] ** 2 for name in policy.measured])
    np.testing.assert_allclose(known @ rows.T - policy.first_gain[0] @ seen, 0.0, atol=1e-12)


def test_reaches_its_mark_on_random_rigs():
    """0.95 of rigs in stick-slip, told nothing; on rigs that no suite has."""
    scores = score(run(LQG(), tuning_suite("default", 150, 590_000_000)))
    assert scores["mitigated"].mean() > 0.95
    assert scores["mitigated"][scores["region"] == "below"].mean() > 0.9


def test_slopes_reach_from_next_to_nothing_to_twenty_times_what_the_bare_drive_bears():
    """The nearest one is never further off than a tenth."""
    bearable = -critical_slope(Rig())
    assert SLOPES[0] < bearable / 5.0
    assert SLOPES[-1] == pytest.approx(20.0 * bearable, rel=0.05)
    np.testing.assert_allclose(SLOPES[1:] / SLOPES[:-1], SLOPES[1] / SLOPES[0])
    assert np.sqrt(SLOPES[1] / SLOPES[0]) < 1.1


def test_clear_errors():
    with pytest.raises(ValueError, match=r"LQG reads one of .*string_torque.* would do: state, encoders, surface"):
        LQG(("top_speed", "speed_reference", "speed_target"))
    with pytest.raises(ValueError, match=r"delay = 11 control steps is not allowed; allowed: 0 to 10"):
        LQG(delay=11)
