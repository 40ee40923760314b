"""The contract of all baselines: batches, memory, sensors, errors."""

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.evaluation import evaluate_policy

import drillrig_env
from baselines import BASELINES, LQG, Constant, make
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.sensors import LONGEST_DELAY, SENSORS
from tests.baselines.episode import BISTABLE, LOAD_STEP, play

FAST = [name for name, kind in BASELINES.items() if not kind.slow]


def supported(name):
    """The named sensors that a baseline works with."""
    found = []
    for sensors in SENSORS:
        try:
            make(name, sensors=sensors)
        except ValueError:
            continue
        found.append(sensors)
    return found


@pytest.mark.parametrize(("name", "sensors"), [(name, sensors) for name in FAST for sensors in supported(name)])
def test_batch_is_its_rigs_one_at_a_time(name, sensors):
    batch, alone = make(name, sensors=sensors), [make(name, sensors=sensors) for _ in range(4)]
    env = gym.make_vec("DrillRig-v0", num_envs=4, sensors=sensors, drive=batch.drive)
    observations, info = env.reset(seed=5)
    state, states = None, [None] * 4
    for step in range(50):
        start = np.full(4, step == 0)
        batch.tell(info)
        actions, state = batch.predict(observations, state, start)
        for i in range(4):
            alone[i].tell({key: value[i] for key, value in info.items() if key in alone[i].privileged})
            action, states[i] = alone[i].predict(observations[i], states[i], start[i : i + 1])
            np.testing.assert_array_equal(action, actions[i])
        observations, *_, info = env.step(actions)


@pytest.mark.parametrize("name", FAST)
def test_each_column_of_memory_is_used(name):
    """With some sensors or others, which may be late."""
    used = np.zeros(BASELINES[name].memory, dtype=bool)
    for sensors in supported(name):
        policy = LQG(sensors, delay=LONGEST_DELAY) if name == "lqg" else make(name, sensors=sensors)
        core = EpisodeBatch(40, scenario="default", sensors=sensors, drive=policy.drive, duration=20.0)
        core.reset(np.arange(40), first_uniforms(3, 40), {"start": "stick_slip"})
        state = None
        for _ in range(core.steps):
            policy.tell(core.info())
            actions, state = policy.predict(core.observations, state)
            used |= (state[0] != 0.0).any(axis=0)
            core.step(actions)
    assert used.all()


@pytest.mark.parametrize("name", FAST)
def test_an_episode_that_begins_anew_forgets_the_one_before(name):
    policy = make(name)
    env = gym.make_vec("DrillRig-v0", num_envs=2, drive=policy.drive)
    first, info = env.reset(seed=1)
    policy.tell(info)
    fresh, _ = policy.predict(first, None, np.array([True, True]))
    state, observations = None, first
    for step in range(30):
        policy.tell(info)
        actions, state = policy.predict(observations, state, np.full(2, step == 0))
        observations, *_, info = env.step(actions)
    policy.tell({key: np.asarray(value) for key, value in env.reset(seed=1)[1].items() if key in policy.privileged})
    again, _ = policy.predict(first, state, np.array([True, True]))
    np.testing.assert_array_equal(again, fresh)


def test_only_the_one_that_plans_by_simulation_is_slow():
    assert [name for name, kind in BASELINES.items() if kind.slow] == ["mppi"]


def test_constant_goes_to_the_target_from_rest_and_stays_in_stick_slip():
    _, references = play(Constant(), {"speed_target": 4.0, "start": "rest"})
    assert np.allclose(np.diff(references[:20]), 0.2)
    assert references[-1] == pytest.approx(4.0, abs=1e-6)
    assert not play(Constant(), BISTABLE)[0]["is_success"]
    assert not play(Constant(), LOAD_STEP)[0]["is_success"]


def test_sb3_evaluates_a_baseline():
    returns, _ = evaluate_policy(Constant(), drillrig_env.make_sb3(4, seed=0, duration=5.0), n_eval_episodes=4)
    assert returns < 0


@pytest.mark.parametrize("name", BASELINES)
def test_every_baseline_refuses_sensors_without_the_target(name):
    with pytest.raises(ValueError, match=rf"{BASELINES[name].__name__} reads .*speed_target.*sensors that would do: "):
        make(name, sensors=("top_speed", "speed_reference"))


@pytest.mark.parametrize("name", BASELINES)
def test_what_is_tuned_are_arguments_with_values_within_their_bounds(name):
    kind = BASELINES[name]
    for values in kind.tuned_values.values():
        assert set(values) == set(kind.tuned)
        assert all(low <= values[key] <= high for key, (low, high) in kind.tuned.items())
        kind(**values)


def test_unknown_name_gets_a_hint():
    with pytest.raises(ValueError, match="did you mean jump_ease"):
        make("jump_eas")
