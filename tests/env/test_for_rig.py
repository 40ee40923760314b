"""What belongs to a rig: a rig that is the chapter's scaled has the chapter's environment scaled; others a sane one."""

import warnings
from dataclasses import fields

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.env_checker import check_env as check_env_sb3

import drillrig_env
from drillrig_env import Rig, Task
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.sensors import CHANNELS, SENSORS
from drillrig_env.scales import Scales
from drillrig_env.slowest_mode import slowest_period
from tests.rigs import FAST, FIELD, scaled

EVERYTHING = tuple(channel.name for channel in CHANNELS)
RIGS, STEPS = 12, 120
OTHERS = {
    "fast": {"rig": FAST},
    "field": {"rig": FIELD},
    "field at its speeds": {"rig": FIELD, "largest_reference": 50.0},
}


def episodes(**given):
    """Observations (as numbers before they are clipped) and rewards of some rigs under the same random actions."""
    core = EpisodeBatch(RIGS, sensors=EVERYTHING, threads=1, **given)
    core.reset(np.arange(RIGS), np.random.default_rng(3).random((RIGS, 12)))
    random, seen, rewards = np.random.default_rng(4), [core.observations], []
    for _ in range(STEPS):
        core.step(random.uniform(-1.0, 1.0, (RIGS, 1)).astype(np.float32))
        seen.append(core.observations)
        rewards.append(core.episodes["reward"].copy())
    return np.array(seen), np.array(rewards), core


@pytest.fixture(scope="module")
def chapters():
    return {noise: episodes(noise=noise) for noise in (0.0, 1.0)}


def test_all_scales_of_the_chapters_rig_are_exactly_one():
    scales = Scales.of(Rig())
    names = [name for name, kind in vars(Scales).items() if isinstance(kind, property) and name[0] != "_"]
    numbers = [getattr(scales, name) for name in names if name not in ("friction", "counted", "units")]
    assert numbers == [1.0] * (len(names) - 3)
    assert (scales.speed, scales.counted, set(scales.units.values())) == (1.0, Rig(), {1.0})
    assert slowest_period(Rig()) == pytest.approx(1.0 / Rig().string_frequencies[0], rel=1e-14)


def test_the_chapters_task_is_that_of_the_documentation():
    task = Task.for_rig(Rig())
    assert (task.control_period, task.duration, task.largest_reference, task.slew_limit) == (0.1, 60.0, 10.0, 2.0)
    assert (task.targets.low, task.targets.high, task.reward.time_constant) == (0.01, 10.0, 2.5)
    assert (task.scenario.speed_target, task.scenario.normal_force) == ((1.0, 5.0), (5.0, 30.0))
    assert task.sensors is SENSORS["state"]


@pytest.mark.parametrize(("time", "torque"), [(2.0, 1.0), (0.25, 2.0**20), (2.0**-10, 0.125), (2.0**10, 1.0)])
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_scaled_rig_has_the_scaled_environment_bit_for_bit(chapters, noise, time, torque):
    seen, rewards, core = episodes(rig=scaled(time, torque), noise=noise)
    expected, rewards_expected, own = chapters[noise]
    np.testing.assert_array_equal(seen, expected)
    np.testing.assert_array_equal(rewards, rewards_expected)
    np.testing.assert_array_equal(core.episodes["state"][:, 2], own.episodes["state"][:, 2] / time)
    np.testing.assert_array_equal(core.episodes["normal_force"], own.episodes["normal_force"])
    np.testing.assert_array_equal(core.mitigated, own.mitigated)


@pytest.mark.parametrize(
    ("time", "torque", "angle"), [(1.0 / 6.5, 1.0, 1.0), (3.0, 1e6, 1.0), (1e4, 1e-5, 1.0), (2.0, 0.5, 10.0)]
)
def test_a_scaled_rig_has_the_scaled_environment_within_the_steppers_error(chapters, time, torque, angle):
    given = {} if angle == 1.0 else {"largest_reference": 10.0 * angle / time}
    seen, rewards, core = episodes(rig=scaled(time, torque, angle), noise=0.0, **given)
    expected, rewards_expected, own = chapters[0.0]
    np.testing.assert_allclose(seen, expected, atol=3e-6)
    np.testing.assert_allclose(rewards, rewards_expected, atol=1e-6)
    np.testing.assert_array_equal(core.episodes["start"], own.episodes["start"])


def test_forces_scale_with_the_radius_at_which_the_pin_presses(chapters):
    core = episodes(rig=Rig(r_1=4.0 * Rig().r_1))[2]
    np.testing.assert_array_equal(4.0 * core.episodes["normal_force"], chapters[0.0][2].episodes["normal_force"])


@pytest.mark.parametrize("given", OTHERS.values(), ids=OTHERS)
@pytest.mark.parametrize("force", [0.5, 1.0, 1.5])
def test_observations_in_stick_slip_stay_within_5(given, force):
    task = Task.for_rig(**given, sensors=EVERYTHING)
    middle = sum(task.scenario.normal_force) / 2.0
    core = EpisodeBatch(20, task, threads=1)
    targets = np.linspace(*task.scenario.speed_target, 20)
    pins = {"start": "stick_slip", "normal_force": force * middle, "speed_target": targets, "load_steps": []}
    core.reset(np.arange(20), np.random.default_rng(0).random((20, 12)), pins)
    seen = []
    for _ in range(core.steps):
        core.step(np.zeros((20, 1), dtype=np.float32))
        seen.append(core.observations)
    within = (np.abs(np.array(seen)) <= 5.0).mean(axis=0)
    assert within.min() >= 0.99
    spread = np.ptp(np.array(seen), axis=0).max(axis=0)
    assert spread[[EVERYTHING.index(name) for name in ("bit_speed", "twist_12", "string_torque")]].min() > 0.5


@pytest.mark.parametrize("given", OTHERS.values(), ids=OTHERS)
def test_environment_checkers_are_silent(given):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gym.make("DrillRig-v0", **given)
        check_env(env.unwrapped, skip_render_check=True)
        check_env_sb3(gym.make("DrillRigSurface-v0", **given).unwrapped)


@pytest.mark.parametrize("given", OTHERS.values(), ids=OTHERS)
def test_all_forms_agree_bit_for_bit(given):
    given = {**given, "duration": 2.0}
    single = gym.make("DrillRigSurface-v0", **given)
    several = gym.make_vec("DrillRigSurface-v0", num_envs=3, **given)
    learners = drillrig_env.make_sb3(3, env_id="DrillRigSurface-v0", seed=5, **given)
    seen, many, theirs = single.reset(seed=6)[0], several.reset(seed=5)[0], learners.reset()
    random = np.random.default_rng(1)
    for _ in range(single.unwrapped.core.steps - 1):
        np.testing.assert_array_equal(seen, many[1])
        np.testing.assert_array_equal(many, theirs)
        actions = random.uniform(-1.0, 1.0, (3, 1)).astype(np.float32)
        (seen, reward, *_), (many, rewards, *_), (theirs, *_) = (
            single.step(actions[1]),
            several.step(actions),
            learners.step(actions),
        )
        assert reward == rewards[1]


def test_what_is_given_stays_and_the_rest_is_the_rigs():
    task = Task.for_rig(FAST, scenario={"stick_slip": 1.0, "steady": 0.0}, reward={"action": 0.5}, slew_limit=7.0)
    assert (task.scenario.stick_slip, task.reward.action, task.slew_limit) == (1.0, 0.5, 7.0)
    assert task.scenario.speed_target == pytest.approx((6.5, 32.5))
    assert task.scenario.friction.v_b == pytest.approx(1.0 / 6.5)
    assert task.reward.time_constant == pytest.approx(2.5 / 6.5)
    own = drillrig_env.Scenario(speed_target=(2.0, 3.0))
    assert Task.for_rig(FAST, scenario=own, reward=drillrig_env.Reward()).scenario is own
    assert Task.for_rig(FAST, reward={"time_constant": 2.0}).reward.time_constant == 2.0
    assert Task.for_rig(FAST).sensors == Task.for_rig(FAST, sensors=Task.for_rig(FIELD).sensors).sensors
    assert Task.for_rig(FAST) == Task.for_rig(FAST)


def test_a_drive_that_is_given_is_seen_as_it_is_whatever_the_gains_that_it_replaces():
    drive, other = {"k_p": 0.5, "k_i": 0.1}, Rig(k_p=0.01, k_i=1.0 / 300.0)
    assert Task(drive=drive).sensors is SENSORS["state"]
    assert Task(rig=other, drive=drive).sensors == SENSORS["state"]
    assert Task(rig=other).sensors != SENSORS["state"]


@pytest.mark.parametrize("share", [0.005, 0.2])
def test_control_period_is_an_argument(share):
    period = share * slowest_period(Rig())
    env = gym.make("DrillRig-v0", control_period=period).unwrapped
    assert env.core.steps == round(60.0 / period)
    assert env.metadata["render_fps"] == max(1, round(1.0 / period))
    env.reset(seed=0, options={"start": "steady", "speed_target": 3.0, "normal_force": 0.0})
    for _ in range(3):
        env.step(np.ones(1, dtype=np.float32))
    assert env.core.episodes["speed_reference"][0] == pytest.approx(3.0 + 3 * 2.0 * period)


def test_a_finer_control_period_sees_the_same_rig():
    ends = []
    for period, steps in ((0.1, 100), (0.02, 500)):
        core = EpisodeBatch(1, control_period=period)
        pins = {"start": "steady", "speed_target": 4.0, "normal_force": 20.0, "load_steps": [(2.0, 25.0)]}
        core.reset(np.zeros(1, dtype=int), np.full((1, 12), 0.5), pins)
        for _ in range(steps):
            core.step(np.zeros((1, 1), dtype=np.float32))
        ends.append((core.episodes["state"][0, :7].copy(), core.episodes["mean"][0]))
    np.testing.assert_allclose(ends[0][0], ends[1][0], atol=1e-6)
    assert ends[0][1] == pytest.approx(ends[1][1], abs=1e-2)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"control_period": 0.01}, r"control_period = 0.01 s .* >= 0.0116525 and <= 0.466101 s"),
        ({"control_period": 0.47}, "control_period = 0.47 s"),
        ({"control_period": "0.1"}, "control_period = '0.1' is text"),
        ({"largest_reference": 0.0}, "largest_reference = 0.0 rad/s .* > 0"),
        ({"largest_reference": [10.0]}, "largest_reference"),
        ({"largest_reference": 3e-311}, "largest_reference = 3e-311 rad/s .* >= 1e-05 and <= 1e"),
        ({"rig": FAST, "slew_limit": 1e5}, r"slew_limit = 100000.0 rad/s\^2 .* <= 42250"),
        ({"rig": FIELD, "scenario": drillrig_env.Scenario()}, r"\(1.0, 5.0\) rad/s .* each >= 0.004 and <= 4 rad/s"),
        ({"scenario": {"speed_target": (2.0, 11.0)}}, r"speed_target = \(2.0, 11.0\)"),
        ({"rig": FIELD, "duration": 1e6}, "duration = 1000000.0 s"),
    ],
)
def test_what_the_rig_does_not_allow_is_refused(given, words):
    if "scenario" in given and given.get("rig") is FIELD:
        given = {**given, "largest_reference": 4.0}
    with pytest.raises(ValueError, match=words):
        Task.of(**given)


def test_targets_are_those_of_the_rig():
    env = gym.make("DrillRig-v0", rig=FAST)
    env.reset(seed=0, options={"speed_target": 60.0})
    with pytest.raises(ValueError, match=r"speed_target = 66.0 rad/s .* <= 65"):
        env.reset(options={"speed_target": 66.0})


def test_lengths_of_episodes_are_whole_steps_of_the_rig():
    assert Task.for_rig(FIELD, duration=60.0).steps == 308
    assert Task.for_rig(FAST).steps == 600
    assert Task.for_rig(FIELD).steps == round(300 + 300 / Scales.of(FIELD).damping)
    assert Task.for_rig(FIELD, control_period=0.2, duration=60.0).duration == pytest.approx(60.0)
    assert {item.name for item in fields(Task)} >= {"control_period", "largest_reference"}


@pytest.mark.parametrize("change", [{"J_1": 1e200}, {"J_1": 1e-300}, {"k_1": 1e300}, {"k_1": 1e-300, "k_2": 1e-300}])
def test_a_rig_whose_period_cannot_be_computed_is_refused(change):
    with pytest.raises(ValueError, match=r"Rig: [Jk]_1 = .* is beyond what can be computed; allowed: .* >= 1e-09"):
        Task.for_rig(change)


def test_a_string_without_damping_is_loaded_lightly_and_has_long_episodes():
    task = Task.for_rig({"d_1": 0.0, "d_2": 0.0})
    assert task.scenario.normal_force == (0.5, 3.0)
    assert (task.duration, task.control_period) == (330.0, 0.1)
    assert Task.for_rig({"d_1": 0.2, "d_2": 0.2}).scenario.normal_force == (5.0, 30.0)


def test_a_task_that_moves_to_another_rig_takes_the_numbers_of_that_rig():
    task = Task.of({"scenario": "wide", "reward": "phases"}, noise=1.0)
    moved = Task.of(task, rig=FAST)
    assert moved == Task.for_rig(FAST, scenario="wide", reward="phases", noise=1.0)
    assert Task.of(moved, rig=Rig()) == task
    assert Task.of(Task(), largest_reference=20.0) == Task(largest_reference=20.0)
    assert Task.of(Task(slew_limit=1.5, duration=3.0), rig=FAST).slew_limit == 1.5
    own = drillrig_env.Scenario(speed_target=(7.0, 8.0))
    assert Task.of(Task(scenario=own), rig=FAST).scenario is own
    assert gym.make("DrillRig-v0", task=Task(), rig=FAST).unwrapped.task == Task.for_rig(FAST)


@pytest.mark.parametrize("rig", [Rig(d_1=0.0), Rig(d_2=0.011)])
def test_episode_of_a_rig_of_the_chapters_period_is_whole_control_steps_long(rig):
    task = Task.for_rig(rig)
    assert task.control_period == 0.1
    assert task.duration != 60.0
    assert task.duration / 0.1 == pytest.approx(round(task.duration / 0.1), abs=1e-9)


@pytest.mark.parametrize(
    "change",
    [
        {"C_m": 4e-2},
        {"C_m": 9e-3, "K_T": 0.014, "J_1": 0.004, "k_2": 0.05},
        {"C_1": 0.4, "C_2": 1.1},
        {"J_1": 1e-12, "J_2": 1e-12, "J_3": 1e-12},
    ],
    ids=["motor", "weak motor", "discs", "light"],
)
def test_the_current_stays_in_its_channel_where_viscous_losses_take_most_of_it(change):
    env = gym.make_vec("DrillRig-v0", num_envs=6, rig=change)
    env.reset(
        seed=1,
        options={"start": "stick_slip", "speed_target": np.linspace(*env.unwrapped.task.scenario.speed_target, 6)},
    )
    place = env.unwrapped.task.sensors.names.index("current")
    seen = np.array([env.step(np.zeros((6, 1), np.float32))[0][:, place] for _ in range(100)])
    assert 0.5 < np.abs(seen).max() < 5.0
