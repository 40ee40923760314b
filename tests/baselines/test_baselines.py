import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.evaluation import evaluate_policy

import drillrig_env
from baselines import BASELINES, Constant, JumpEase, JumpEaseEstimated, make
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite


def play(policy, options, **arguments):
    """One episode of the chapter's rig under a policy; its info at the end and the references on the way."""
    env = gym.make("DrillRig-v0", scenario="nominal", **arguments)
    observation, info = env.reset(seed=0, options=options)
    state, start, references = None, np.array([True]), []
    while True:
        policy.tell(info)
        action, state = policy.predict(observation, state, start)
        start = np.array([False])
        observation, _, _, truncated, info = env.step(action)
        references.append(info["speed_reference"])
        if truncated:
            return info, np.array(references)


BISTABLE = {"normal_force": 20.0, "speed_target": 3.2, "start": "stick_slip"}


def test_constant_leaves_a_bistable_rig_in_stick_slip_and_jump_ease_frees_it():
    assert not play(Constant(), BISTABLE)[0]["is_success"]
    info, references = play(JumpEase(), BISTABLE)
    assert info["is_success"]
    assert references.max() > 4.0
    assert references[-1] == pytest.approx(3.2, abs=1e-4)


def test_jump_ease_eases_to_just_above_the_critical_speed_where_the_target_is_below():
    info, references = play(JumpEase(margin=0.2), {"normal_force": 20.0, "speed_target": 1.5, "start": "stick_slip"})
    assert references[-1] == pytest.approx(2.688 + 0.2, abs=1e-3)
    assert info["bit_speed"] == pytest.approx(references[-1], rel=0.02)


def test_estimated_form_frees_a_rig_from_what_it_sees_alone():
    assert JumpEaseEstimated.told == ()
    info, references = play(JumpEaseEstimated(), BISTABLE)
    assert info["is_success"]
    assert references.max() > 4.8  # past the fold of 4.79 rad/s


@pytest.mark.parametrize("normal_force", [20.0, 30.0])
def test_estimated_friction_is_near_the_true_one_once_calm(normal_force):
    env = gym.make("DrillRig-v0", scenario="nominal")
    observation, _ = env.reset(
        seed=1, options={"normal_force": normal_force, "speed_target": 4.0, "start": "stick_slip"}
    )
    policy, state = JumpEaseEstimated(), None
    for _ in range(599):
        action, state = policy.predict(observation, state)
        observation, *_ = env.step(action)
    estimate = policy.estimates(state[0])[0]
    rig = drillrig_env.Rig()
    true = drillrig_env.Friction(normal_force)
    for speed in (0.01, 2.0, 4.0):
        assert estimate.torque(rig, speed)[0] == pytest.approx(
            true.torque(rig, speed), rel=0.1
        )  # seen ten times a second


def test_constant_goes_to_the_target_from_rest():
    _, references = play(Constant(), {"speed_target": 4.0, "start": "rest"})
    assert np.allclose(np.diff(references[:20]), 0.2)
    assert references[-1] == pytest.approx(4.0, abs=1e-6)


def test_jump_ease_keeps_its_score_on_random_rigs():
    """A shipped heuristic must reach its score: guards physics, environment and scores together."""
    scores = score(run(JumpEase(), suite("default", 300)))
    above = scores["region"] == "above"
    assert scores["mitigated"][above].mean() > 0.9
    assert scores["mitigated"][~above].mean() < 0.05  # by nature: it stays above the critical speed
    assert scores["calm"].mean() > 0.95


@pytest.mark.parametrize("name", BASELINES)
def test_batch_is_its_rigs_one_at_a_time(name):
    env = gym.make_vec("DrillRig-v0", num_envs=6)
    observations, info = env.reset(seed=5)
    batch, state = make(name), None
    alone, states = [make(name) for _ in range(6)], [None] * 6
    for step in range(50):
        start = np.full(6, step == 0)
        batch.tell(info)
        actions, state = batch.predict(observations, state, start)
        for i in range(6):
            alone[i].tell({key: value[i] for key, value in info.items() if key in alone[i].told})
            action, states[i] = alone[i].predict(observations[i], states[i], start[i : i + 1])
            np.testing.assert_array_equal(action, actions[i])
        observations, *_, info = env.step(actions)


def test_memory_begins_anew_with_an_episode():
    policy = JumpEase()
    policy.tell({"normal_force": 20.0, "mu_s": 0.5, "mu_k": 0.306, "v_b": 1.0})
    observation = np.zeros((1, 11), np.float32)
    observation[0, 2] = 1.0
    _, used = policy.predict(observation, None, np.array([True]))
    _, again = policy.predict(observation, used, np.array([True]))
    _, longer = policy.predict(observation, used, np.array([False]))
    np.testing.assert_array_equal(used[0], again[0])
    assert longer[0][0, 0] > used[0][0, 0]


def test_sb3_evaluates_a_baseline():
    returns, _ = evaluate_policy(Constant(), drillrig_env.make_sb3(4, seed=0, duration=5.0), n_eval_episodes=4)
    assert returns < 0


def test_clear_errors():
    with pytest.raises(ValueError, match="did you mean jump_ease"):
        make("jump_eas")
    with pytest.raises(RuntimeError, match=r"told normal_force.*call tell"):
        JumpEase().predict(np.zeros((1, 11), np.float32))
