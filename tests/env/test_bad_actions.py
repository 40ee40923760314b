"""Actions that are none: refused in one sentence by every form, before anything has moved."""

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env

NONE = [
    np.array([np.nan]),
    np.array([None], dtype=object),
    np.array([1j]),
    np.array(["0.5"]),
    np.array([True]),
    np.zeros(2),
    np.zeros((1, 1)),
    np.float32(0.5),
    0.5,
    None,
]
ALSO_NONE_FOR_MANY = [
    np.array([[0.0], [np.nan], [0.0]]),
    np.array([[0.0], [None], [0.0]], dtype=object),
    np.array([[0.0], [1j], [0.0]]),
    np.array([["0"], ["1"], ["0"]]),
    np.zeros((3, 1), dtype=bool),
    np.zeros(3),
    np.zeros((2, 1)),
    None,
]


@pytest.mark.parametrize("bad", NONE, ids=repr)
def test_single_refuses_bad_actions(bad):
    env = gym.make("DrillRig-v0").unwrapped
    env.reset(seed=0)
    before = env.core.episodes.copy()
    with pytest.raises(ValueError, match=r"^action .*not allowed; allowed"):
        env.step(bad)
    np.testing.assert_array_equal(env.core.episodes, before)


@pytest.mark.parametrize("bad", ALSO_NONE_FOR_MANY, ids=repr)
@pytest.mark.parametrize("form", ["vector", "sb3"])
def test_vector_and_sb3_refuse_bad_actions(form, bad):
    env = gym.make_vec("DrillRig-v0", num_envs=3) if form == "vector" else drillrig_env.make_sb3(3, seed=0)
    env.reset()
    before = env.core.episodes.copy()
    with pytest.raises(ValueError, match=r"^action.*not allowed; allowed"):
        env.step(bad)
    np.testing.assert_array_equal(env.core.episodes, before)


def test_nan_is_refused_with_the_rig():
    env = gym.make_vec("DrillRig-v0", num_envs=3)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="rig 1"):
        env.step(ALSO_NONE_FOR_MANY[0])


@pytest.mark.parametrize("far", [np.array([np.inf]), np.array([7]), np.array([1e300]), [3.0]])
def test_what_is_too_large_is_clipped(far):
    env, other = gym.make("DrillRig-v0").unwrapped, gym.make("DrillRig-v0").unwrapped
    env.reset(seed=0)
    other.reset(seed=0)
    with np.errstate(over="ignore"):
        seen = env.step(far)[0]
    np.testing.assert_array_equal(seen, other.step(np.ones(1, np.float32))[0])
