"""What Stable-Baselines3 asks of its vector environments."""

import numpy as np
from gymnasium.wrappers import TimeLimit
from stable_baselines3.common.monitor import Monitor

import drillrig_env
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms


def test_reset_gives_the_first_observations_of_the_seeded_rigs():
    env = drillrig_env.make_sb3(3, seed=5)
    found = env.reset()
    core = EpisodeBatch(3)
    core.reset(np.arange(3), first_uniforms(5, 3))
    np.testing.assert_array_equal(found, core.observations)
    assert env.seed(9) == [9, 10, 11]
    assert not np.array_equal(env.reset(), found)


def test_infos_hold_what_a_monitor_reports_and_nothing_else_wraps_a_rig():
    env = drillrig_env.make_sb3(3, seed=0)
    assert env.env_is_wrapped(Monitor) == [True, True, True]
    assert env.env_is_wrapped(Monitor, indices=[1]) == [True]
    assert env.env_is_wrapped(TimeLimit) == [False, False, False]
