"""Infos: the same flat names with the same dtypes at every reset and step, in the single and the vector form."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

import drillrig_env
from drillrig_env.env.scenario import GIVEN, STARTS
from drillrig_env.model import torque_into_string

DTYPES = {
    "bit_speed": np.float64,
    "top_speed": np.float64,
    "speed_reference": np.float64,
    "speed_target": np.float64,
    "normal_force": np.float64,
    "mu_s": np.float64,
    "mu_k": np.float64,
    "v_b": np.float64,
    "torque_into_string": np.float64,
    "delay": np.int64,
    "start": np.int64,
    "rig": np.int64,
    "reward_variance": np.float64,
    "reward_tracking": np.float64,
    "reward_action": np.float64,
    "is_success": np.bool_,
}
CALM = {"start": "steady", "normal_force": 10.0, "speed_target": 4.0, "load_steps": []}
STICKS = {"normal_force": 20.0, "speed_target": 3.0, "start": "stick_slip"}
HOLD, HOLD_TWO = np.zeros(1, np.float32), np.zeros((2, 1), np.float32)


def check(info, shape=()):
    assert {name: value.dtype for name, value in info.items() if not name.startswith("_")} == DTYPES
    assert all(value.shape == shape for name, value in info.items() if not name.startswith("_"))


@pytest.mark.parametrize("name", drillrig_env.ENVIRONMENTS)
def test_infos_of_the_single_form_are_alike_at_every_reset_and_step(name):
    env = gym.make(name, duration=0.5)
    for _ in range(2):
        check(env.reset(seed=3)[1])
        for _ in range(5):
            check(env.step(HOLD)[-1])


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_infos_of_the_vector_form_are_alike_at_every_reset_and_step(mode):
    env = gym.make_vec("DrillRig-v0", num_envs=2, duration=0.5, autoreset_mode=mode)
    check(env.reset(seed=3)[1], (2,))
    finals = 0
    for _ in range(12):
        *_, truncated, info = env.step(HOLD_TWO)
        if "final_info" in info:
            assert truncated.all()
            assert info.pop("_final_obs").all()
            check(info.pop("final_info"), (2,))
            finals += 1
            del info["final_obs"], info["_final_info"]
        assert all(info[f"_{key}"].all() for key in DTYPES)
        check(info, (2,))
    assert finals == (2 if mode == "SameStep" else 0)


def test_native_and_synchronous_vectors_say_the_same():
    arguments = {"num_envs": 2, "duration": 0.4}
    native = gym.make_vec("DrillRig-v0", **arguments)
    threads = gym.make_vec("DrillRig-v0", vectorization_mode="sync", **arguments)
    said = [env.reset(seed=5)[1] for env in (native, threads)]
    for _ in range(10):
        assert said[0].keys() == said[1].keys()
        for key in DTYPES:
            np.testing.assert_array_equal(said[0][key], said[1][key])
            assert said[0][key].dtype == said[1][key].dtype
        said = [env.step(HOLD_TWO)[-1] for env in (native, threads)]


def test_info_says_what_the_episode_is():
    env = gym.make("DrillRig-v0")
    _, info = env.reset(seed=3, options=STICKS)
    assert STARTS[info["start"]] == "stick_slip"
    assert (info["normal_force"], info["speed_target"]) == (20.0, 3.0)
    observation, reward, _, _, info = env.step(np.array([0.5], np.float32))
    assert STARTS[info["start"]] == "stick_slip"
    assert info["reward_variance"] + info["reward_tracking"] + info["reward_action"] == pytest.approx(reward)
    assert info["reward_action"] == pytest.approx(-0.01 * 0.25)
    sensors = env.unwrapped.sensors
    for name in ("bit_speed", "top_speed", "speed_reference", "speed_target"):
        assert sensors.value(observation, name) == pytest.approx(info[name], abs=1e-5)


@pytest.mark.parametrize("torque", [0.0, 0.2])
@pytest.mark.parametrize("start", STARTS[:GIVEN])
def test_the_torque_is_that_of_the_state_at_a_reset_too(start, torque):
    rig = drillrig_env.Rig(T_r2=torque)
    options = {**STICKS, "start": start}
    vector, env = (make("DrillRig-v0", rig=rig, drive=(0.3, 0.2, 0.5)) for make in (gym.make_vec, gym.make))
    for info in (vector.reset(seed=0, options=options)[1], env.reset(seed=0, options=options)[1]):
        state = env.unwrapped.core.episodes["state"][:, :7] if info["start"].shape == () else None
        wanted = torque_into_string(rig, vector.core.episodes["state"][:, :7] if state is None else state)
        assert info["torque_into_string"] == pytest.approx(wanted[0], abs=1e-12)
        assert (abs(wanted[0]) > 0.01) == (start != "rest" or torque > 0.0)


def test_start_is_the_one_that_came_out():
    """Above the fold there is no stick-slip to start in."""
    _, info = gym.make("DrillRig-v0").reset(seed=0, options={**STICKS, "normal_force": 10.0, "speed_target": 3.2})
    assert STARTS[info["start"]] == "steady"


@pytest.mark.parametrize(("options", "success"), [(CALM, True), (STICKS, False)])
def test_success_is_false_until_the_last_step_decides(options, success):
    env = gym.make("DrillRig-v0")
    _, info = env.reset(seed=3, options=options)
    for _ in range(599):
        assert not info["is_success"]
        *_, truncated, info = env.step(HOLD)
        assert not truncated
    *_, truncated, info = env.step(HOLD)
    assert truncated
    assert bool(info["is_success"]) is success
    with pytest.raises(ResetNeeded, match="600 steps is over"):
        env.step(HOLD)


def test_a_normal_force_that_steps_shows_in_the_info():
    env = gym.make("DrillRig-v0")
    env.reset(seed=0, options={**CALM, "load_steps": [(0.2, 17.0)]})
    assert [env.step(HOLD)[-1]["normal_force"] for _ in range(4)] == [10.0, 10.0, 17.0, 17.0]


def test_earlier_infos_keep_their_values():
    env = gym.make("DrillRig-v0", duration=0.2)
    kept, copies = [], []
    for info in (env.reset(seed=0, options=CALM)[1], env.step(HOLD)[-1], env.step(HOLD)[-1], env.reset()[1]):
        kept.append(info)
        copies.append({name: value.copy() for name, value in info.items()})
    env.step(HOLD)
    assert kept == copies


def test_info_of_a_delay_that_is_drawn():
    env = gym.make("DrillRig-v0", delay=(2, 5))
    drawn = {int(env.reset(seed=seed)[1]["delay"]) for seed in range(40)}
    assert drawn == {2, 3, 4, 5}
