"""The native vector form beyond its steps: seeds, lengths, resets under a mask, attributes, frames."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.wrappers import TimeAwareObservation

import drillrig_env
from drillrig_env import Drive, Reward, Rig, Scenario, Task

HOLD = np.zeros((2, 1), np.float32)


def vector(**arguments):
    return gym.make_vec("DrillRig-v0", num_envs=2, **arguments)


@pytest.mark.parametrize("seed", [np.int64(3), 3, [3, 4], np.array([3, 4]), (np.uint8(3), 4)])
def test_every_way_to_give_a_seed(seed):
    np.testing.assert_array_equal(vector().reset(seed=seed)[0], vector().reset(seed=3)[0])


@pytest.mark.parametrize(
    ("seed", "words"),
    [
        ("a", "seed = 'a' is not a number"),
        (-1, "seed = -1"),
        (-(2**70), "seed = -1180591620717411303424 is not allowed; allowed: whole, >= 0"),
        (1.5, "seed = 1.5"),
        (True, "seed = True"),
        ([1], "1 seeds"),
    ],
)
def test_what_is_no_seed_is_refused(seed, words):
    with pytest.raises(ValueError, match=words):
        vector().reset(seed=seed)
    if not isinstance(seed, list):
        with pytest.raises(ValueError, match=words):
            gym.make("DrillRig-v0").reset(seed=seed)
        with pytest.raises(ValueError, match=words):
            drillrig_env.make_sb3(1, seed=seed)


def test_the_seed_that_an_environment_took_itself_can_be_given_to_every_form():
    own = gym.make("DrillRig-v0")
    first, _ = own.reset()
    seed = own.np_random_seed
    assert seed > 2**64
    training = drillrig_env.make_sb3(2, seed=seed)
    for seen in (gym.make("DrillRig-v0").reset(seed=seed)[0], vector().reset(seed=seed)[0][0], training.reset()[0]):
        np.testing.assert_array_equal(seen, first)


def test_numpy_seeds_of_the_single_form():
    env = gym.make("DrillRig-v0")
    np.testing.assert_array_equal(env.reset(seed=np.int64(3))[0], env.reset(seed=3)[0])


def test_seeds_that_are_left_out_go_on():
    env = vector()
    env.reset(seed=[1, 2])
    first = env.reset()[0]
    env.reset(seed=[1, 2])
    again = env.reset(seed=[None, 9])[0]
    np.testing.assert_array_equal(first[0], again[0])
    assert not np.array_equal(first[1], again[1])


def test_spec_says_how_long_an_episode_is():
    for arguments, steps in (({}, 600), ({"duration": 20.0}, 200), ({"duration": 120.0}, 1200)):
        assert vector(**arguments).spec.max_episode_steps == steps
        assert gym.make("DrillRig-v0", **arguments).spec.max_episode_steps == steps
    assert vector(max_episode_steps=50).spec.max_episode_steps == 50
    assert gym.make("DrillRig-v0", max_episode_steps=50).spec.max_episode_steps == 50
    env = TimeAwareObservation(gym.make("DrillRig-v0"), normalize_time=True)
    assert env.max_timesteps == 600
    env.reset(seed=0)
    assert env.step(env.action_space.sample())[0][-1] == pytest.approx(1 / 600)


def test_an_environment_can_be_made_again_from_its_spec():
    for arguments in (
        {"duration": 120.0},
        {"rig": {"k_p": 2.0}},
        {"rig": Rig(k_p=2.0), "scenario": Scenario(spread=0.1), "reward": Reward(action=1.0), "drive": Drive(0.3, 0.2)},
        {"task": Task.of(sensors="encoders", delay=2)},
    ):
        env = gym.make("DrillRig-v0", **arguments)
        again = gym.make(gym.envs.registration.EnvSpec.from_json(env.spec.to_json()))
        assert repr(again.unwrapped.task) == repr(env.unwrapped.task)
        assert again.unwrapped.core.steps == env.unwrapped.core.steps
        np.testing.assert_array_equal(again.reset(seed=1)[0], env.reset(seed=1)[0])


@pytest.mark.parametrize(
    "arguments", [{"duration": 120.0}, {"duration": 20.0}, {"task": {"duration": 120.0}}, {"task": Task(duration=20.0)}]
)
def test_a_spec_of_another_length_is_refused_and_the_ways_out_give_the_length_that_is_asked_for(arguments):
    one, two = gym.make("DrillRig-v0").spec, vector().spec
    steps = Task.of(**arguments).steps
    for make in (
        lambda **more: gym.make(one, **arguments, **more),
        lambda **more: gym.make_vec(one, num_envs=2, **arguments, **more),
        lambda **more: gym.make_vec(two, **arguments, **more),
    ):
        with pytest.raises(ValueError, match=rf"after 600 steps; allowed: with max_episode_steps={steps}"):
            make()
        env = make(max_episode_steps=steps)
        assert env.spec.max_episode_steps == env.unwrapped.core.steps == steps
    assert gym.make(one.id, **arguments).spec.max_episode_steps == steps


@pytest.mark.parametrize("arguments", [{}, {"duration": 120.0}])
def test_a_spec_of_episodes_that_are_cut_short_makes_such_again(arguments):
    cut = gym.make("DrillRig-v0", max_episode_steps=50, **arguments).spec
    assert gym.make(cut).spec.max_episode_steps == 50
    assert gym.make_vec(vector(max_episode_steps=50, **arguments).spec).core.steps == 50


def test_shorter_episodes_are_the_beginnings_of_longer_ones_and_are_judged():
    calm = {"start": "steady", "normal_force": 10.0, "speed_target": 4.0, "load_steps": []}
    short, long, wrapped = vector(max_episode_steps=50), vector(), gym.make("DrillRig-v0", max_episode_steps=50)
    for env in (short, long, wrapped):
        env.reset(seed=0, options=calm)
    for k in range(50):
        seen, rewards, _, truncated, info = short.step(HOLD)
        expected = long.step(HOLD)
        np.testing.assert_array_equal(seen, expected[0])
        np.testing.assert_array_equal(rewards, expected[1])
        assert truncated.all() == wrapped.step(HOLD[0])[3] == (k == 49)
    assert info["is_success"].all()
    assert not expected[-1]["is_success"].any()


def test_a_limit_beyond_the_duration_changes_nothing():
    assert vector(max_episode_steps=10**6).core.steps == 600


def test_vector_resets_under_a_mask_when_autoreset_is_off():
    env = gym.make_vec("DrillRig-v0", num_envs=3, duration=0.2, autoreset_mode="Disabled")
    env.reset(seed=0)
    env.step(np.zeros((3, 1), np.float32))
    env.step(np.zeros((3, 1), np.float32))
    with pytest.raises(ResetNeeded, match="rig 0"):
        env.step(np.zeros((3, 1), np.float32))
    _, info = env.reset(options={"reset_mask": np.array([True, False, True]), "normal_force": np.array([11.0, 13.0])})
    assert info["normal_force"][[0, 2]].tolist() == [11.0, 13.0]
    with pytest.raises(ResetNeeded, match="rig 1"):
        env.step(np.zeros((3, 1), np.float32))


def test_what_is_given_away_may_be_written_into():
    env, other = (vector(duration=0.2, autoreset_mode="Disabled") for _ in range(2))
    mask = np.array([True, False])
    seen = []
    for changed in (env, other):
        changed.reset(seed=0)
        observations, _, _, truncated, info = changed.step(np.zeros((2, 1), np.float32))
        if changed is env:
            observations[:] = 7.0
            truncated[:] = True
            for name in info:
                info[name][:] = 0
        seen.append(changed.reset(options={"reset_mask": mask}))
    np.testing.assert_array_equal(seen[0][0], seen[1][0])
    for name, values in seen[1][1].items():
        np.testing.assert_array_equal(seen[0][1][name], values)


def test_attributes_and_methods_once_for_each_rig():
    env = vector()
    assert env.get_attr("slew_limit") == (2.0, 2.0)
    assert env.call("slew_limit") == (2.0, 2.0)
    env.reset(seed=0)
    states = env.call("get_state")
    assert len(states) == 2
    env.step(HOLD)
    env.call("set_state", states[0])
    assert env.core.episodes["step"].tolist() == [0, 0]
    with pytest.raises(AttributeError):
        env.get_attr("slew_limi")


def test_frames_of_all_rigs(caplog):
    pytest.importorskip("pygame", reason="rendering needs the extra `render` (pygame-ce)")
    env, alone = vector(render_mode="rgb_array"), gym.make("DrillRig-v0", render_mode="rgb_array")
    with pytest.raises(ResetNeeded, match="no episode to draw"):
        env.render()
    env.reset(seed=4)
    alone.reset(seed=5)
    for _ in range(3):
        env.step(HOLD)
        alone.step(HOLD[1])
    frames = env.render()
    assert [frame.shape for frame in frames] == [(540, 960, 3)] * 2
    np.testing.assert_array_equal(frames[1], alone.render())
    assert not np.array_equal(*frames)
    with pytest.raises(ValueError, match="'human' is not known for many rigs; allowed: None, rgb_array"):
        vector(render_mode="human")
    with pytest.warns(UserWarning, match="render"):
        assert vector().render() is None


def test_frames_begin_anew_with_an_episode():
    pytest.importorskip("pygame", reason="rendering needs the extra `render` (pygame-ce)")
    env = vector(render_mode="rgb_array", duration=0.3)
    first = env.reset(seed=4)[0]
    for _ in range(4):
        seen = env.step(HOLD)[0]
    assert not np.array_equal(first, seen)
    begun = env.render()
    env.set_state(env.get_state())
    np.testing.assert_array_equal(env.render(), begun)
