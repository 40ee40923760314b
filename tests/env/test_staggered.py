"""Rigs of a batch whose episodes do not end together, and delays that differ from one rig to the next."""

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env  # noqa: F401  (registers the environments)
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms

HOLD = np.zeros((2, 1), np.float32)


@pytest.fixture
def staggered():
    """Two rigs at their last step: of the first, which began anew after 3 of 10 steps, the seventh."""
    env = gym.make_vec("DrillRig-v0", num_envs=2, duration=1.0)
    env.reset(seed=0)
    for _ in range(3):
        env.step(HOLD)
    env.reset(options={"reset_mask": np.array([True, False])})
    for _ in range(7):
        *_, truncated, _ = env.step(HOLD)
    return env, truncated


def test_one_rig_ends_and_begins_anew_while_the_other_goes_on(staggered):
    env, truncated = staggered
    assert truncated.tolist() == [False, True]
    before = env.unwrapped.core.episodes["step"].copy()
    _, rewards, _, truncated, _ = env.step(HOLD)
    after = env.unwrapped.core.episodes["step"]
    assert before.tolist() == [7, 10]
    assert after.tolist() == [8, 0]
    assert (rewards[0] != 0.0, rewards[1]) == (True, 0.0)
    assert truncated.tolist() == [False, False]
    ends = [env.step(HOLD)[3].tolist() for _ in range(10)]
    assert ends == [[False, False], [True, False], *[[False, False]] * 7, [False, True]]


def test_each_delay_of_a_range_is_as_likely_as_the_others():
    core = EpisodeBatch(1000, delay=(2, 5), threads=1)
    core.reset(np.arange(1000), first_uniforms(0, 1000), {"start": "steady"})
    counts = np.bincount(core.episodes["delay"], minlength=6)
    assert counts[:2].tolist() == [0, 0]
    np.testing.assert_allclose(counts[2:], 250, atol=45)  # three standard deviations
