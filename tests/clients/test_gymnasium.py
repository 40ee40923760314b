"""Gymnasium's own wrappers, and its three kinds of vector environments beside each other."""

import copy
import pickle
import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import drillrig_env

RIGS = 3
SINGLE = {
    "TimeAwareObservation": lambda env: wrappers.TimeAwareObservation(env, flatten=True),
    "RecordEpisodeStatistics": wrappers.RecordEpisodeStatistics,
    "TimeLimit": lambda env: wrappers.TimeLimit(env, 4),
    "NormalizeObservation": wrappers.NormalizeObservation,
    "NormalizeReward": wrappers.NormalizeReward,
    "FrameStackObservation": lambda env: wrappers.FlattenObservation(wrappers.FrameStackObservation(env, 3)),
    "DelayObservation": lambda env: wrappers.DelayObservation(env, 2),
    "MaxAndSkipObservation": lambda env: wrappers.MaxAndSkipObservation(env, 2),
    "StickyAction": lambda env: wrappers.StickyAction(env, 0.5),
    "RescaleAction": lambda env: wrappers.RescaleAction(env, np.float32(0.0), np.float32(1.0)),
    "ClipAction": wrappers.ClipAction,
    "Autoreset": wrappers.Autoreset,
    "OrderEnforcing": wrappers.OrderEnforcing,
}
VECTOR = {
    "RecordEpisodeStatistics": wrappers.vector.RecordEpisodeStatistics,
    "NormalizeObservation": wrappers.vector.NormalizeObservation,
    "NormalizeReward": wrappers.vector.NormalizeReward,
    "ClipAction": wrappers.vector.ClipAction,
    "RescaleAction": lambda env: wrappers.vector.RescaleAction(env, np.float32(0.0), np.float32(1.0)),
    "FlattenObservation": wrappers.vector.FlattenObservation,
    "DictInfoToList": wrappers.vector.DictInfoToList,
}


NOT_RESET = ("NormalizeObservation", "NormalizeReward")  # what these have learnt outlives a reset: the checker objects


@pytest.mark.parametrize("name", SINGLE)
def test_wrapped_environment_passes_the_checker_and_ends(name):
    env = SINGLE[name](gym.make("DrillRig-v0", duration=1.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        of_wrapper = ("different from the unwrapped version", "infinity. This is probably", "symmetric and normalized")
        warnings.filterwarnings("ignore", message=f".*({'|'.join(of_wrapper)})")
        if name not in NOT_RESET:
            check_env(env, skip_render_check=True)
    env.reset(seed=0)
    for _ in range(12):
        observation, reward, terminated, truncated, _ = env.step(env.action_space.sample())
        assert env.observation_space.contains(observation)
        assert np.isfinite(reward)
        if (terminated or truncated) and name != "Autoreset":
            env.reset()


def test_shorter_time_limit_still_tells_of_success():
    env = gym.make("DrillRig-v0", max_episode_steps=5)
    assert env.spec.max_episode_steps == 5
    _, info = env.reset(seed=0)
    for k in range(5):
        assert "is_success" in info
        *_, truncated, info = env.step(np.zeros(1, np.float32))
        assert truncated == (k == 4)
    assert "is_success" in info


@pytest.mark.parametrize("seconds", [0.5, 60.0, 90.0])
def test_duration_is_the_length_of_an_episode_in_every_form(seconds):
    steps = round(seconds / 0.1)
    env = gym.make("DrillRig-v0", duration=seconds)
    env.reset(seed=0)
    truncated = [env.step(np.zeros(1, np.float32))[3] for _ in range(steps)]
    assert (sum(truncated), truncated[-1]) == (1, True)
    assert env.spec.max_episode_steps in (None, steps)
    vector = gym.make_vec("DrillRig-v0", num_envs=2, duration=seconds)
    vector.reset(seed=0)
    truncated = [vector.step(np.zeros((2, 1), np.float32))[3] for _ in range(steps)]
    assert np.sum(truncated) == 2
    assert truncated[-1].all()


TAKEN = {  # modes in which Gymnasium's wrappers work; the others take all
    "NormalizeObservation": {AutoresetMode.NEXT_STEP},
    "FlattenObservation": {AutoresetMode.NEXT_STEP, AutoresetMode.DISABLED},
}


@pytest.mark.parametrize("mode", AutoresetMode, ids=lambda mode: mode.name)
@pytest.mark.parametrize("name", VECTOR)
def test_wrapped_vector_steps_beyond_the_end_of_episodes(name, mode):
    if mode not in TAKEN.get(name, AutoresetMode):
        pytest.skip("Gymnasium's wrapper refuses this mode")
    env = VECTOR[name](gym.make_vec("DrillRig-v0", num_envs=RIGS, duration=0.5, autoreset_mode=mode))
    env.action_space.seed(0)
    env.reset(seed=0)
    for _ in range(13):
        observations, rewards, terminated, truncated, _ = env.step(env.action_space.sample())
        assert np.isfinite(rewards).all()
        assert env.observation_space.contains(observations)
        if mode == AutoresetMode.DISABLED and (terminated | truncated).any():
            env.reset(options={"reset_mask": terminated | truncated})
    env.close()


def vector(kind, mode, name, **kwargs):
    if kind == "native":
        return gym.make_vec(name, num_envs=RIGS, autoreset_mode=mode, **kwargs)
    return gym.make_vec(name, num_envs=RIGS, vectorization_mode=kind, vector_kwargs={"autoreset_mode": mode}, **kwargs)


def same(first, second, where):
    """Whether two infos are the same to the last bit: keys, dtypes, masks, and values where the masks say so."""
    assert set(first) == set(second), where
    for key, value in first.items():
        other = second[key]
        if isinstance(value, dict):
            same(value, other, f"{where}, {key}")
        elif key == "final_obs":
            for one, two in zip(value, other, strict=True):
                if one is not None and two is not None:
                    np.testing.assert_array_equal(one, two, f"{where}, {key}")
        else:
            assert value.dtype == other.dtype, f"{where}, {key}"
            mask = slice(None) if key.startswith("_") else first[f"_{key}"]
            np.testing.assert_array_equal(value[mask], other[mask], f"{where}, {key}")


@pytest.mark.parametrize("mode", AutoresetMode, ids=lambda mode: mode.name)
@pytest.mark.parametrize("kind", ["sync", "async"])
@pytest.mark.parametrize("name", drillrig_env.ENVIRONMENTS)
def test_gymnasiums_vectors_and_the_native_one_agree_bit_for_bit(name, kind, mode):
    pair = [vector(which, mode, name, duration=0.5) for which in (kind, "native")]
    try:
        (first, info), (second, other) = (env.reset(seed=3, options={"normal_force": 18.0}) for env in pair)
        np.testing.assert_array_equal(first, second)
        same(info, other, "reset")
        actions = np.random.default_rng(0).uniform(-1, 1, (13, RIGS, 1)).astype(np.float32)
        for k, action in enumerate(actions):
            steps = [env.step(action) for env in pair]
            for one, two in zip(steps[0][:4], steps[1][:4], strict=True):
                np.testing.assert_array_equal(one, two)
                assert one.dtype == two.dtype
            same(steps[0][4], steps[1][4], f"step {k}")
            if mode == AutoresetMode.DISABLED and steps[0][3].any():
                mask = steps[0][3]
                (first, info), (second, other) = (env.reset(options={"reset_mask": mask}) for env in pair)
                np.testing.assert_array_equal(first[mask], second[mask])
                same(info, other, f"reset after step {k}")
    finally:
        for env in pair:
            env.close()


def test_infos_have_the_same_keys_and_types_at_every_reset_and_step():
    env = gym.make("DrillRig-v0", duration=0.5)
    kinds = []
    for episode in range(2):
        kinds.append({key: np.asarray(value).dtype for key, value in env.reset(seed=episode)[1].items()})
        for _ in range(5):
            info = env.step(np.zeros(1, np.float32))[4]
            kinds.append({key: np.asarray(value).dtype for key, value in info.items()})
    assert all(kind == kinds[0] for kind in kinds)


COPIES = {"deepcopy": copy.deepcopy, "pickle": lambda env: pickle.loads(pickle.dumps(env))}


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("began", [False, True])
def test_async_vector_of_copies(how, began):
    original = gym.make("DrillRig-v0", duration=0.5)
    if began:
        original.reset(seed=9)
        original.step(np.ones(1, np.float32))
    envs = gym.vector.AsyncVectorEnv([lambda: COPIES[how](original)] * 2)
    native = gym.make_vec("DrillRig-v0", num_envs=2, duration=0.5)
    try:
        np.testing.assert_array_equal(envs.reset(seed=0)[0], native.reset(seed=0)[0])
        for k in range(7):
            action = np.full((2, 1), 0.1 * k, np.float32)
            for one, two in zip(envs.step(action)[:4], native.step(action)[:4], strict=True):
                np.testing.assert_array_equal(one, two)
    finally:
        envs.close()


@pytest.mark.parametrize("kind", ["sync", "async", "native"])
def test_attributes_are_read_and_set(kind):
    env = vector(kind, AutoresetMode.NEXT_STEP, "DrillRig-v0")
    pins = {"start": "steady", "load_steps": []}
    try:
        env.set_attr("slew_limit", 1.0)
        assert tuple(env.get_attr("slew_limit")) == tuple(env.call("slew_limit")) == (1.0,) * RIGS
        _, info = env.reset(seed=0, options=pins)
        before = info["speed_reference"]
        info = env.step(np.ones((RIGS, 1), np.float32))[4]
        np.testing.assert_allclose(info["speed_reference"] - before, 0.1, rtol=1e-12)
    finally:
        env.close()


@pytest.mark.clients
def test_video_of_an_episode(tmp_path):
    pytest.importorskip("pygame")
    pytest.importorskip("moviepy")
    env = wrappers.RecordVideo(gym.make("DrillRig-v0", duration=0.5, render_mode="rgb_array"), str(tmp_path))
    env.reset(seed=0)
    for _ in range(5):
        env.step(np.zeros(1, np.float32))
    env.close()
    assert (tmp_path / "rl-video-episode-0.mp4").stat().st_size > 0
