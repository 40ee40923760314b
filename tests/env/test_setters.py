"""What can be given anew while an environment lives: effective on all forms, and refused for everything else."""

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.vec_env import DummyVecEnv

import drillrig_env
from drillrig_env import Reward, Scenario
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.task import CHANGEABLE, TASK_FIELDS

UP, UP_TWO = np.ones(1, np.float32), np.ones((2, 1), np.float32)
FORCED = {"normal_force": (17.0, 17.0), "load_step": 0.0}


def made(**given):
    """Every form, with a way to set an attribute of it."""
    single, wrapped = gym.make("DrillRig-v0", **given).unwrapped, gym.make("DrillRig-v0", **given)
    vector, training = gym.make_vec("DrillRig-v0", num_envs=2, **given), drillrig_env.make_sb3(2, seed=0, **given)
    sync = gym.make_vec("DrillRig-v0", num_envs=2, vectorization_mode="sync", **given)
    dummy = DummyVecEnv([lambda: gym.make("DrillRig-v0", **given)] * 2)
    return {
        "attribute": (single, lambda name, value: setattr(single, name, value)),
        "wrapper": (wrapped, wrapped.set_wrapper_attr),
        "vector": (vector, vector.set_attr),
        "vector, one value a rig": (vector, lambda name, value: vector.set_attr(name, [value, value])),
        "vector, attribute": (vector, lambda name, value: setattr(vector, name, value)),
        "vector of Gymnasium": (sync, sync.set_attr),
        "sb3": (training, training.set_attr),
        "sb3, attribute": (training, lambda name, value: setattr(training, name, value)),
        "dummy": (dummy, lambda name, value: dummy.env_method("change", **{name: value})),
    }


HOW = tuple(made())


def begin(env):
    if isinstance(env, gym.Env | gym.vector.VectorEnv):
        return env.reset(seed=0)
    env.seed(0)
    return env.reset()


def core_of(env):
    return env.envs[0].unwrapped.core if hasattr(env, "envs") else env.unwrapped.core


def step(env):
    """References and rewards after a step upwards."""
    if isinstance(env, gym.Env):
        _, reward, _, _, info = env.step(UP)
        return float(info["speed_reference"]), reward
    rewards = env.step(UP_TWO)[1]
    return float(core_of(env).episodes["speed_reference"][0]), float(rewards[0])


def force(env):
    return float(core_of(env).episodes["normal_force"][0])


@pytest.mark.parametrize("how", HOW)
def test_slew_limit_holds_from_the_next_step_on(how):
    env, give = made()[how]
    begin(env)
    first = step(env)[0]
    give("slew_limit", 0.5)
    assert step(env)[0] - first == pytest.approx(0.05)


@pytest.mark.parametrize("how", HOW)
def test_reward_holds_from_the_next_step_on(how):
    env, give = made()[how]
    for value in ({"variance": 0.0, "tracking": 0.0, "action": 3.0}, Reward(variance=0.0, tracking=0.0, action=2.0)):
        begin(env)
        give("reward", value)
        assert step(env)[1] == pytest.approx(-Reward.of(value).action)


@pytest.mark.parametrize("how", HOW)
def test_scenario_holds_from_the_next_episode_on(how):
    env, give = made()[how]
    begin(env)
    before = force(env)
    give("scenario", FORCED)
    step(env)
    assert force(env) == before
    begin(env)
    assert force(env) == 17.0


@pytest.mark.parametrize("how", HOW)
def test_noise_holds_from_the_next_observation_on(how):
    env, give = made(sensors="surface", noise=0.0, delay=0)[how]
    begin(env)
    give("noise", {"current": 5.0})
    seen = env.step(UP if isinstance(env, gym.Env) else UP_TWO)[0]
    core = core_of(env)
    shown = core.sensors.values(np.atleast_2d(seen)[0])
    assert abs(shown["current"] - core.episodes["state"][0, 5]) > 0.1
    assert shown["top_speed"] == pytest.approx(core.episodes["state"][0, 4], abs=1e-6)


@pytest.mark.parametrize("how", HOW)
def test_a_delay_holds_from_the_next_episode_on_and_is_no_longer_than_it_was_made_for(how):
    env, give = made(sensors="surface", delay=3)[how]
    begin(env)
    give("delay", (1, 1))
    step(env)
    assert core_of(env).episodes["delay"][0] == 3
    begin(env)
    assert core_of(env).episodes["delay"][0] == 1
    with pytest.raises(ValueError, match="delay = 4 control steps is not allowed; allowed: 0 to 3, that of the"):
        give("delay", 4)
    assert core_of(env).delay == (1, 1)


def test_a_scenario_holds_for_automatic_resets_too():
    for env in (
        gym.make_vec("DrillRig-v0", num_envs=2, duration=0.2),
        drillrig_env.make_sb3(2, seed=0, duration=0.2),
    ):
        begin(env)
        env.set_attr("scenario", FORCED)
        for _ in range(3):
            env.step(UP_TWO)
        assert env.core.episodes["normal_force"].tolist() == [17.0, 17.0]


@pytest.mark.parametrize("how", [how for how in HOW if how != "dummy"])
@pytest.mark.parametrize("name", [name for name in TASK_FIELDS if name not in CHANGEABLE])
def test_what_an_environment_is_made_for_cannot_be_set(how, name):
    _, give = made()[how]
    with pytest.raises(
        AttributeError, match=f"{name} cannot be changed.*make a new one; scenario, reward, slew_limit, noise and"
    ):
        give(name, None)


@pytest.mark.parametrize("how", ["wrapper", "vector", "vector of Gymnasium", "sb3"])
@pytest.mark.parametrize("name", ["core", "_advance", "task"])
def test_what_an_environment_is_made_of_cannot_be_set(how, name):
    env, give = made()[how]
    begin(env)
    with pytest.raises(AttributeError, match=f"set_attr: {name} cannot be changed; scenario, reward, slew_limit,"):
        give(name, 1)
    step(env)


def test_a_wrapper_may_have_attributes_of_its_own():
    env = gym.make("DrillRig-v0")
    env.set_wrapper_attr("note", "mine")
    assert env.get_wrapper_attr("note") == "mine"
    with pytest.raises(AttributeError, match="no attribute 'note'"):
        env.unwrapped.set_wrapper_attr("note", "mine")


@pytest.mark.parametrize("name", TASK_FIELDS)
def test_fields_can_be_read_on_every_form(name):
    core = EpisodeBatch(2)
    for env in (gym.make("DrillRig-v0").unwrapped, gym.make_vec("DrillRig-v0", num_envs=2), drillrig_env.make_sb3(2)):
        assert repr(getattr(env, name)) == repr(getattr(env.task, name)) == repr(getattr(core, name))
    assert repr(gym.make("DrillRig-v0").get_wrapper_attr(name)) == repr(getattr(core, name))


@pytest.mark.parametrize("how", [how for how in HOW if how != "dummy"])
@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("slew_limit", -1.0, "slew_limit = -1.0 rad/s"),
        ("scenario", "defalt", "did you mean default"),
        ("reward", {"varianc": 1.0}, "did you mean variance"),
    ],
)
def test_what_is_not_allowed_leaves_all_as_it_was(how, name, value, words):
    env, give = made()[how]
    task = core_of(env).task
    with pytest.raises(ValueError, match=words):
        give(name, value)
    assert core_of(env).task is task


def test_vectors_refuse_names_that_nothing_has_and_values_that_differ():
    for env in (gym.make_vec("DrillRig-v0", num_envs=2), drillrig_env.make_sb3(2)):
        with pytest.raises(AttributeError, match="no attribute 'scenari'; did you mean scenario"):
            env.set_attr("scenari", "wide")
    with pytest.raises(ValueError, match="differs between rigs"):
        gym.make_vec("DrillRig-v0", num_envs=2).set_attr("slew_limit", [1.0, 2.0])
    with pytest.raises(ValueError, match="for some rigs only"):
        drillrig_env.make_sb3(2).set_attr("slew_limit", 1.0, indices=0)


def test_change_takes_several_at_once_and_names_what_it_does_not_know():
    env = gym.make("DrillRig-v0").unwrapped
    env.change(scenario=Scenario(spread=0.1), slew_limit=1.0)
    assert (env.scenario.spread, env.slew_limit) == (0.1, 1.0)
    with pytest.raises(ValueError, match="'slew_limi' cannot be changed; did you mean slew_limit"):
        env.change(slew_limi=1.0)
    with pytest.raises(AttributeError, match="rig cannot be changed"):
        env.change(rig=None, slew_limit=2.0)
    assert env.slew_limit == 1.0
