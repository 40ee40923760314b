"""Episodes that begin in a given state: the physics goes on from it, and the info says so."""

import gymnasium as gym
import numpy as np
import pytest

from drillrig_env import STARTS, Friction, Rig, make_sb3, simulate
from drillrig_env.model import steady_state, torque_into_string

CYCLE = simulate(friction=Friction(20.0), speed_reference=2.0, duration=40.0)
STATE = CYCLE.state[-37]
PINS = {"normal_force": 20.0, "mu_s": 0.5, "mu_k": 0.306, "v_b": 1.0, "speed_target": 2.0, "load_steps": []}
HOLD = np.zeros(1, np.float32)


def physics(env):
    return env.unwrapped.core.episodes["state"][:, :7].copy()


def test_an_episode_goes_on_from_a_simulations_state():
    env = gym.make("DrillRig-v0", scenario="nominal")
    _, info = env.reset(seed=0, options={**PINS, "state": STATE})
    assert STARTS[info["start"]] == "given"
    assert (info["bit_speed"], info["top_speed"], info["speed_reference"]) == (STATE[2], STATE[4], 2.0)
    assert info["torque_into_string"] == torque_into_string(Rig(), STATE)
    run = simulate(friction=Friction(20.0), initial_state=STATE, speed_reference=2.0, duration=3.0, sample_period=0.1)
    for expected in run.state[1:]:
        info = env.step(HOLD)[4]
        np.testing.assert_allclose(physics(env)[0], expected, atol=1e-9)
        assert STARTS[info["start"]] == "given"


@pytest.mark.parametrize("drive", [None, (0.3, 0.2, 0.5)])
def test_an_episode_goes_on_bit_for_bit_from_another_ones_state_and_reference(drive):
    first, second = (gym.make("DrillRigSurface-v0", drive=drive, noise=0.0, delay=0) for _ in range(2))
    first.reset(seed=0, options={**PINS, "start": "stick_slip"})
    for _ in range(20):
        last, *_, info = first.step(np.array([0.7], np.float32))
    pins = {**PINS, "state": physics(first)[0], "speed_reference": info["speed_reference"]}
    seen, info = second.reset(seed=9, options=pins)
    assert info["speed_reference"] == pins["speed_reference"] > 2.0
    names = ("top_speed", "current", "voltage", "speed_reference", "speed_target")
    sensors = first.unwrapped.sensors
    for name in names:
        assert sensors.value(seen, name) == sensors.value(last, name), name
    for _ in range(10):
        first.step(HOLD)
        second.step(HOLD)
        np.testing.assert_array_equal(physics(first), physics(second))


def test_the_running_statistics_are_those_of_a_bit_that_has_always_turned_so():
    env = gym.make("DrillRig-v0").unwrapped
    seen, _ = env.reset(seed=0, options={**PINS, "state": STATE})
    values = env.sensors.values(seen)
    assert values["bit_speed_mean"] == pytest.approx(STATE[2], abs=1e-6)
    assert values["bit_speed_deviation"] == 0.0
    assert values["string_torque_mean"] == pytest.approx(torque_into_string(env.rig, STATE), abs=1e-6)
    calm = steady_state(env.rig, Friction(20.0), 4.0)
    env.reset(seed=0, options={**PINS, "speed_target": 4.0, "state": calm})
    rewards = [env.step(HOLD)[1] for _ in range(20)]
    assert np.abs(rewards).max() < 1e-12


def test_all_forms_begin_in_the_same_states():
    states = np.stack([STATE, CYCLE.state[-50]])
    pins = {"state": states, "speed_reference": [2.0, 2.5]}
    single = [gym.make("DrillRig-v0") for _ in range(2)]
    for i, env in enumerate(single):
        env.reset(seed=3 + i, options={"state": states[i].tolist(), "speed_reference": pins["speed_reference"][i]})
    vector, sb3 = gym.make_vec("DrillRig-v0", num_envs=2), make_sb3(2, seed=3)
    vector.reset(seed=3, options=pins)
    sb3.set_options(pins)
    sb3.reset()
    for _ in range(3):
        expected = np.concatenate([physics(env) for env in single])
        np.testing.assert_array_equal(physics(vector), expected)
        np.testing.assert_array_equal(sb3.core.episodes["state"][:, :7], expected)
        for env in single:
            env.step(HOLD)
        vector.step(HOLD[None].repeat(2, axis=0))
        sb3.step(HOLD[None].repeat(2, axis=0))


def test_one_state_for_seven_rigs_is_not_one_number_a_rig():
    env = make_sb3(7, seed=0)
    env.set_options({"state": STATE})
    env.reset()
    np.testing.assert_array_equal(env.core.episodes["state"][:, :7], np.tile(STATE, (7, 1)))
    assert [STARTS[i] for i in env.core.episodes["start"]] == ["given"] * 7


def test_given_states_reach_the_rigs_that_are_reset():
    env = gym.make_vec("DrillRig-v0", num_envs=3, autoreset_mode="Disabled", duration=0.5)
    env.reset(seed=0)
    states = np.stack([STATE, CYCLE.state[-50]])
    mask = np.array([True, False, True])
    before = physics(env)[1]
    _, info = env.reset(options={"reset_mask": mask, "state": states, "start": "given"})
    np.testing.assert_array_equal(physics(env)[[0, 2]], states)
    np.testing.assert_array_equal(physics(env)[1], before)
    assert (info["start"][mask] == STARTS.index("given")).all()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"state": [0.0] * 6}, r"shape of state = \(6,\) is not allowed; allowed: \(7,\) or \(2, 7\): twist_12 in rad"),
        ({"state": np.zeros((3, 7))}, r"shape of state = \(3, 7\)"),
        ({"state": [[0.0] * 7, [0.0] * 6]}, "state = .* numbers of shape"),
        ({"state": "rest"}, "shape of state = 'rest'"),
        ({"state": [True] * 7}, "shape of state"),
        (
            {"state": [0, 0, 0, 0, 0, np.nan, 0]},
            "current of state = nan A is not allowed; allowed: any finite number A",
        ),
        ({"state": [0, 0, np.inf, 0, 0, 0, 0]}, "bit_speed of state = inf rad/s"),
        ({"state": [0.0] * 7, "start": "rest"}, "start = rest is not allowed; allowed: none beside a state, or given"),
        ({"start": "given"}, "start = given is not allowed; .* or a state beside it"),
        ({"start": ["given", "rest"]}, "start = given is not allowed"),
        ({"speed_reference": 2.0}, "speed_reference = 2.0 rad/s is not allowed without a state"),
        ({"state": [0.0] * 7, "speed_reference": 10.1}, "speed_reference = 10.1 rad/s .*<= 10 rad/s"),
        ({"state": [0.0] * 7, "speed_reference": -0.1}, "speed_reference = -0.1 rad/s"),
        ({"state": [0.0] * 7, "speed_reference": [1.0] * 3}, "shape of speed_reference"),
    ],
)
def test_impossible_states_are_refused(options, words):
    env = gym.make_vec("DrillRig-v0", num_envs=2)
    with pytest.raises(ValueError, match=words):
        env.reset(seed=0, options=options)
