"""A state that is no longer finite ends in an error, and reaches nobody."""

import pickle
import re

import gymnasium as gym
import numpy as np
import pytest

from drillrig_env import Friction, Rig, make_sb3, simulate, simulate_batch
from drillrig_env.stepper.finite import NotFiniteError, check_finite

RUNAWAY = Rig(k_i=1e9)


def test_first_rig_and_sample_are_named():
    states = np.zeros((3, 4, 7))
    check_finite(states, np.arange(4.0), "here")
    states[1, 2, 4] = np.inf
    with pytest.raises(NotFiniteError, match=r"here: top_speed = inf rad/s of rig 1 at 2 s is not finite; check"):
        check_finite(states, np.arange(4.0), "here")


@pytest.mark.filterwarnings("error")
def test_rig_that_runs_away_is_an_error_of_simulation():
    with pytest.raises(NotFiniteError, match="rig 0"):
        simulate(RUNAWAY, duration=5.0)


def test_time_is_that_of_the_whole_run_and_the_name_that_of_the_call():
    with pytest.raises(NotFiniteError, match=r"^simulate: .* of rig 0 at 4\.\d* s"):
        simulate(normal_force=[(0.0, 10.0), (4.0, 1e300)], duration=9.0)
    with pytest.raises(NotFiniteError, match=r"^simulate_batch: "):
        simulate_batch(RUNAWAY, duration=5.0)


@pytest.mark.filterwarnings("error")
def test_impossible_load_is_refused_with_its_rig():
    frictions = Friction(np.array([10.0, 20.0, 1e300]))
    with pytest.raises(NotFiniteError, match=r"rig 2 at 0\.1 s"):
        simulate_batch(None, frictions, duration=1.0)
    with pytest.raises(NotFiniteError, match="rig 0"):
        simulate(friction=Friction(1e300), duration=1.0)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("start", ["stick_slip", "steady", "rest"])
def test_impossible_load_never_reaches_an_observer(start):
    options = {"normal_force": 1e300, "start": start}
    with pytest.raises(NotFiniteError, match=r"rig 0 \(seed 5\) at 0\.\d s"):
        _play(gym.make("DrillRig-v0"), options)
    vector = gym.make_vec("DrillRig-v0", num_envs=3)
    options["normal_force"] = np.array([10.0, 1e300, 10.0])
    with pytest.raises(NotFiniteError, match=r"rig 1 \(seed 6\)"):
        _play(vector, options, np.zeros((3, 1), dtype=np.float32))


def test_stable_baselines_gets_the_error_too():
    pytest.importorskip("stable_baselines3")
    env = make_sb3(2, seed=3)
    env.set_options({"normal_force": 1e300})
    env.reset()
    env = pickle.loads(pickle.dumps(env))
    with pytest.raises(NotFiniteError, match=r"rig 0 \(seed 3\)"):
        env.step(np.zeros((2, 1), dtype=np.float32))


def _play(env, options=None, action=np.zeros(1, dtype=np.float32)):  # noqa: B008  (never written to)
    env.reset(seed=5, options=options)
    for _ in range(20):
        observation, reward, *_ = env.step(action)
        assert np.isfinite(observation).all()
        assert np.isfinite(reward).all()


def test_time_that_is_named_is_the_first_at_which_the_state_is_lost():
    runaway = {"rig": Rig(k_p=0.0, k_i=300.0), "speed_reference": 3.0, "sample_period": 1.0}
    with pytest.raises(NotFiniteError) as caught:
        simulate_batch(**runaway, duration=60.0)
    time = float(re.search(r"at ([\d.]+) s", str(caught.value))[1])
    assert 1.0 < time < 60.0
    assert np.isfinite(simulate_batch(**runaway, duration=time - 1.0)).all()
    with pytest.raises(NotFiniteError, match=f"at {time:g} s"):
        simulate_batch(**runaway, duration=time)


def test_step_that_is_not_solved_is_told_from_overflow():
    states = np.zeros((1, 2, 7))
    states[0, 1] = np.nan
    with pytest.raises(NotFiniteError, match="twist_12 = nan rad of rig 0 at 1 s is not known: a step before it"):
        check_finite(states, np.arange(2.0), "here")
