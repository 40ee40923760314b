"""A run by hand is the environment's, bit for bit; both lanes meet the same; nothing jumps at a hand."""

import json

import gymnasium as gym
import numpy as np
import pytest

from drillrig_env.course import COLUMNS
from drillrig_env.env.recorded import Recorded
from drillrig_env.env.single import DrillRigEnv
from drillrig_env.model import STATE_NAMES
from drillrig_env.room.lanes import Lanes
from drillrig_env.room.setting import Setting

SURFACE = Setting(a="ppo_surface", b="soft_torque", sensors="surface", noise=2.0, delay=3, seed=7, k_i=1.5)


def played_by_hand(stock, setting):
    """A run in which the operator does all there is to do."""
    lanes = Lanes(setting, stock)
    for step in range(120):
        if step == 20:
            lanes.given.set({"normal_force": 18.0, "mu_s": 0.55})
        if step == 30:
            lanes.given.ramp("speed_target", 3.3, 2.5, lanes.step_number)
            lanes.given.ramp("v_b", 1.2, 4.0, lanes.step_number)
        if step == 40:
            lanes.lane("A").take(1.1)
        if step == 70:
            lanes.lane("A").take(None)
            lanes.lane("B").take(lanes.lane("B").speed_reference)
        lanes.step()
    return lanes


@pytest.mark.parametrize(
    "setting", [Setting(b="constant"), SURFACE, Setting(rig="field_2500m", start="rest", a="jump_ease", b="z_torque")]
)
def test_a_run_by_hand_is_kept_and_replayed_by_the_environment_bit_for_bit(stock, setting, tmp_path):
    lanes = played_by_hand(stock, setting)
    lanes.as_recorded().write(tmp_path / "run.json")
    run = Recorded.read(tmp_path / "run.json")
    rewards = lanes.record.as_csv("AB")
    for lane in lanes.lanes:
        env = DrillRigEnv(**run.environment(lane.name))
        env.reset(**run.reset)
        for action in run.actions(lane.name):
            observation, *_ = env.step(action)
        ours, theirs = lane.core.episodes[0], env.core.episodes[0]
        for name in ("state", "speed_reference", "reward", "terms", "noise", "voltage", "string_torque", "mean"):
            np.testing.assert_array_equal(ours[name], theirs[name], err_msg=f"{lane.name} {name}")
        np.testing.assert_array_equal(lane._seen[0], observation)
    assert rewards.count("\n") == 121


def test_a_run_is_replayed_by_gym_make_and_in_the_room(stock):
    lanes = played_by_hand(stock, SURFACE)
    run = Recorded.of(json.loads(json.dumps(lanes.as_recorded().as_json())))
    env = gym.make("drillrig_env:DrillRigSurface-v0", **run.environment("B"))
    env.reset(**run.reset)
    for action in run.actions("B"):
        env.step(action)
    state = lanes.lane("B").core.episodes["state"]
    np.testing.assert_array_equal(env.unwrapped.core.episodes["state"], state)
    again = Lanes(Setting(), stock, run)
    while not again.at_end:
        again.step()
    assert again.step_number == 120
    for ours, theirs in zip(lanes.lanes, again.lanes, strict=True):
        np.testing.assert_array_equal(ours.core.episodes["state"], theirs.core.episodes["state"])
    assert again.as_recorded().as_json()["course"] == run.as_json()["course"]


def test_lanes_with_one_policy_are_one(stock):
    lanes = Lanes(Setting(a="z_torque", b="z_torque", sensors="surface", seed=3), stock)
    for _ in range(50):
        lanes.step()
    first, second = (lane.core.episodes for lane in lanes.lanes)
    assert first == second


def test_another_seed_is_another_run(stock):
    ends = []
    for seed in (0, 1):
        lanes = Lanes(Setting(seed=seed), stock)
        lanes.step()
        ends.append(lanes.lane("A").core.episodes["state"][0].copy())
    assert not np.array_equal(*ends)


def test_taking_over_and_giving_back_do_not_jump(stock):
    lanes = Lanes(Setting(a="z_torque", b="z_torque"), stock)
    a, b = lanes.lanes
    largest = a.task.slew_limit * a.task.control_period

    def step():
        before = a.speed_reference
        lanes.step()
        assert abs(a.speed_reference - before) <= largest * (1 + 1e-6)

    for _ in range(15):
        step()
    held = a.speed_reference
    a.take(held)
    for _ in range(10):
        step()
    assert a.speed_reference == pytest.approx(held, abs=1e-6)  # held where it was, while B goes on
    assert b.speed_reference != pytest.approx(held, abs=1e-2)
    a.take(None)
    for _ in range(250):
        step()
    assert a.verdict.now(2.5).mitigated


def test_what_is_shown_passes_through_the_states(stock):
    lanes = Lanes(Setting(a="constant", b="soft_torque"), stock)
    for _ in range(20):
        step = lanes.step()
    for lane, shown in zip(lanes.lanes, step.shown, strict=True):
        states = dict(zip(STATE_NAMES, lane.core.episodes["state"][0], strict=False))
        for row, name in enumerate(("bit_speed", "collar_speed", "top_speed", "twist_12", "twist_23")):
            assert shown.signals[row, -1] == np.float32(states[name])
        assert shown.signals[5, -1] == np.float32(lane.core.episodes["torque_into_string"][0])
        assert shown.values[0] == np.float32(lane.speed_reference)


def test_the_first_values_are_those_of_the_start(stock):
    lanes = Lanes(Setting(normal_force=22.0, mu_k=0.2, start="steady"), stock)
    episode = lanes.lane("A").core.episodes[0]
    assert [episode[name] for name in COLUMNS] == [22.0, 0.5, 0.2, 1.0, 2.5]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"a": "nobody"}, "policy 'nobody' is not known here"),
        ({"a": "../../etc/passwd"}, "is not known here"),
        ({"a": "my.py:Law"}, "is not known here"),
        ({"rig": "/etc/passwd"}, "rig '/etc/passwd' is not known here"),
        ({"a": "ppo", "sensors": "surface"}, "ppo sees twist_12"),
        ({"sensors": "eyes"}, "sensors"),
        ({"noise": -1.0}, "noise = -1.0 is not allowed"),
        ({"delay": 11}, "delay = 11 control steps"),
        ({"delay": 1.5}, "delay = 1.5 control steps"),
        ({"k_i": 0.0}, "k_i = 0.0 V/rad"),
        ({"k_i": 1e4}, "run away"),
        ({"seed": -1}, "seed = -1"),
        ({"start": "given"}, "start"),
        ({"speed_target": 11.0}, "speed_target"),
        ({"normal_force": -3.0}, "normal_force = -3.0 N"),
        ({"normal_force": "abc"}, "'abc' is not a number"),
        ({"mu_s": 0.1}, ">= mu_k = 0.306"),
        ({"v_b": 0}, "v_b = 0 s/rad"),
        ({"colour": "red"}, "unknown setting 'colour'"),
    ],
)
def test_a_setting_that_cannot_be_is_refused_with_a_sentence(stock, changes, sentence):
    with pytest.raises(ValueError, match=r"control room|Friction|DrillRig|ppo|Course|policy") as refused:
        Lanes(Setting().changed(changes), stock)
    assert sentence in str(refused.value)


def test_another_rig_takes_its_own_numbers():
    setting = Setting(normal_force=20.0, k_p=4.0, noise=1.0).changed({"rig": "field_2500m"})
    assert (setting.normal_force, setting.k_p, setting.noise) == (None, None, 1.0)
    assert Setting(normal_force=20.0).changed({"rig": "laboratory", "seed": 3}).normal_force == 20.0


def test_a_run_without_a_step_cannot_be_kept(stock):
    with pytest.raises(ValueError, match="nothing to keep yet"):
        Lanes(Setting(), stock).as_recorded()
