"""The three forms: contracts of Gymnasium and SB3, seeds, and one result bit for bit."""

import subprocess
import sys
import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.env_checker import check_env as check_env_sb3

import drillrig_env

RIGS, STEPS = 5, 640  # beyond the end of an episode
ACTIONS = np.random.default_rng(11).uniform(-1, 1, (STEPS, RIGS, 1)).astype(np.float32)


@pytest.mark.parametrize("name", drillrig_env.ENVIRONMENTS)
def test_both_checkers_pass_without_a_warning(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gym.make(name)
        check_env(env.unwrapped)
        check_env_sb3(env)


def test_module_prefix_registers_the_environment():
    code = "import gymnasium as gym; print(gym.make('drillrig_env:DrillRig-v0').spec.id)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True).stdout
    assert out.strip() == "DrillRig-v0"


VARIANTS = {
    "state": ("DrillRig-v0", {}),
    "surface": ("DrillRigSurface-v0", {}),
    "late": ("DrillRig-v0", {"noise": 1.0, "delay": (1, 5), "slew_limit": 1.0}),
    "varying": ("DrillRig-v0", {"scenario": {"wandering": {}, "tilt": {"turns": (1, 2)}, "target_step": 0.8}}),
    "soft drive": ("DrillRigSurface-v0", {"drive": (0.04, 0.06, 1.0)}),
}


@pytest.fixture(scope="module", params=VARIANTS)
def variant(request):
    return VARIANTS[request.param]


def singles(seed, variant, same_step=False):
    """The run of RIGS single environments under ACTIONS, as a vector environment would show it."""
    name, kwargs = variant
    channels = gym.make(name).observation_space.shape[0]
    observations, rewards = np.empty((STEPS, RIGS, channels), np.float32), np.zeros((STEPS, RIGS))
    for i in range(RIGS):
        env = gym.make(name, **kwargs)
        env.reset(seed=seed + i)
        over = False
        for k in range(STEPS):
            if over and not same_step:
                observations[k, i], _ = env.reset()
                over = False
                continue
            observations[k, i], rewards[k, i], _, over, _ = env.step(ACTIONS[k, i])
            if over and same_step:
                observations[k, i], _ = env.reset()
    return observations, rewards


@pytest.mark.parametrize("threads", [1, 2])
def test_vector_form_is_the_single_form_bit_for_bit(threads, variant):
    env = gym.make_vec(variant[0], num_envs=RIGS, threads=threads, **variant[1])
    env.reset(seed=42)
    expected, expected_rewards = singles(42, variant)
    for k in range(STEPS):
        observations, rewards, _, _, _ = env.step(ACTIONS[k])
        np.testing.assert_array_equal(observations, expected[k])
        np.testing.assert_array_equal(rewards, expected_rewards[k])


@pytest.mark.parametrize("form", ["sb3", "same_step"])
def test_forms_that_reset_in_the_same_step_are_the_single_form_bit_for_bit(form, variant):
    name, kwargs = variant
    expected, expected_rewards = singles(42, variant, same_step=True)
    if form == "sb3":
        env = drillrig_env.make_sb3(RIGS, seed=42, env_id=name, **kwargs)
        env.reset()
    else:
        env = gym.make_vec(name, num_envs=RIGS, autoreset_mode=gym.vector.AutoresetMode.SAME_STEP, **kwargs)
        env.reset(seed=42)
    for k in range(STEPS):
        observations, rewards, *_ = env.step(ACTIONS[k])
        np.testing.assert_array_equal(observations, expected[k])
        np.testing.assert_array_equal(rewards, expected_rewards[k].astype(rewards.dtype))


def test_large_batch_on_threads_is_one_thread_bit_for_bit():
    results = []
    for threads in (1, 2, 4):
        env = gym.make_vec("DrillRig-v0", num_envs=800, threads=threads)
        env.reset(seed=0)
        results.append([env.step(np.full((800, 1), a, np.float32))[0] for a in (0.3, -1.0, 0.7)])
    np.testing.assert_array_equal(results[0], results[1])
    np.testing.assert_array_equal(results[0], results[2])


def test_seeds():
    env = gym.make("DrillRig-v0")
    first, _ = env.reset(seed=7)
    second, _ = env.reset()
    again, _ = env.reset(seed=7)
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, second)
    np.testing.assert_array_equal(env.reset()[0], second)
    assert not np.array_equal(env.reset(seed=8)[0], first)


def test_global_generator_is_not_touched():
    np.random.seed(3)  # noqa: NPY002 - the global generator is what this test watches
    expected = np.random.random()  # noqa: NPY002
    np.random.seed(3)  # noqa: NPY002
    env = gym.make_vec("DrillRig-v0", num_envs=3)
    env.reset(seed=1)
    env.step(np.zeros((3, 1), np.float32))
    assert np.random.random() == expected  # noqa: NPY002


def test_earlier_observations_keep_their_values():
    env = gym.make("DrillRig-v0")
    first, _ = env.reset(seed=0)
    kept = first.copy()
    second, *_ = env.step(np.ones(1, np.float32))
    kept_second = second.copy()
    env.reset()
    np.testing.assert_array_equal(first, kept)
    np.testing.assert_array_equal(second, kept_second)
