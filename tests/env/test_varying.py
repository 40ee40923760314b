"""What varies within an episode: courses, wandering friction, tilted discs, targets."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from scipy import stats

from drillrig_env import Course, Friction, Scenario, Task, Tilt, Wandering, make_sb3, simulate
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.draws import draw_episodes
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.scenario import UNIFORMS
from drillrig_env.simulation import SIGNALS

REST = np.zeros((1, 1), np.float32)
STATE = np.array([0.0, 0.0, 3.0, 3.0, 3.0, 1.3, 2.1])
PINS = {"state": STATE, "speed_target": 3.0}


def played(scenario, steps, pins, **fields):
    """States and records of an episode without actions, after each of some control steps."""
    core = EpisodeBatch(1, scenario=scenario, **fields)
    core.reset(np.zeros(1, dtype=np.intp), first_uniforms(3, 1), pins)
    records = [core.episodes[0].copy()]
    for _ in range(steps):
        core.step(REST)
        records.append(core.episodes[0].copy())
    return np.stack(records)


def test_an_episode_follows_its_course():
    course = Course(
        np.arange(0.0, 6.0, 0.1), normal_force=lambda t: 15.0 + 9.0 * np.sin(2.0 * t), v_b=lambda t: 1.0 + 0.1 * t
    )
    pins = {**PINS, "mu_s": 0.5, "mu_k": 0.306}
    records = played({"course": course}, 55, pins)
    run = simulate(None, Friction(), STATE, 3.0, 5.5, 0.1, course=course)
    np.testing.assert_allclose(records["state"][:, :7], run.state, atol=1e-9)
    table = course.table(0.1 * np.arange(55))
    np.testing.assert_array_equal(records["normal_force"][1:], table[:, 0])
    np.testing.assert_array_equal(records["v_b"][1:], table[:, 3])


def test_an_episode_begins_with_what_its_course_gives_at_first():
    scenario = {
        "course": {"time": [0.0, 1.0], "normal_force": [25.0, 5.0], "speed_target": [1.7, 3.0]},
        "load_step": 1.0,
    }
    core = EpisodeBatch(50, scenario=scenario)
    core.reset(np.arange(50), first_uniforms(0, 50))
    assert np.all(core.episodes["normal_force"] == 25.0)
    assert np.all(core.episodes["speed_target"] == 1.7)
    assert not np.isfinite(core.episodes["load_times"]).any()
    for _ in range(11):
        core.step(np.zeros((50, 1), np.float32))
    assert np.all(core.episodes["normal_force"] == 5.0)
    assert np.all(core.episodes["speed_target"] == 3.0)


@pytest.mark.parametrize("turns", [1, 4])
def test_an_episode_on_a_tilted_disc_is_the_simulation_from_its_angle(turns):
    tilt = Tilt(0.4, turns, 0.3)
    pins = {**PINS, "normal_force": 20.0, "mu_s": 0.5, "mu_k": 0.306, "v_b": 1.0, "load_steps": []}
    records = played({"tilt": tilt}, 50, pins)
    angle = records["state"][0, 7]
    assert 0.0 < angle < 2.0 * np.pi
    run = simulate(None, Friction(20.0), STATE, 3.0, 5.0, 0.1, tilt=Tilt(0.4, turns, 0.3 + turns * angle))
    np.testing.assert_allclose(records["state"][:, :7], run.state, atol=1e-6)
    travelled = np.unwrap(records["state"][:, 7])
    fine = simulate(None, Friction(20.0), STATE, 3.0, 5.0, 0.001, tilt=Tilt(0.4, turns, 0.3 + turns * angle))
    np.testing.assert_allclose(travelled[-1] - travelled[0], np.trapezoid(fine.bit_speed, fine.time), atol=1e-4)


def test_a_disc_that_does_not_turn_out_of_its_plane_turns_true():
    plain, true = (simulate(speed_reference=3.0, duration=20.0, tilt=tilt) for tilt in (None, Tilt(0.3, 0)))
    assert np.array_equal(plain.state, true.state)
    assert np.array_equal(true.normal_force, plain.normal_force)
    assert Tilt(0.3, 0).factor(1.0) == 1.0
    cores = [EpisodeBatch(64, scenario={"tilt": tilt}, privileged=True) for tilt in (None, Tilt(0.3, (0, 2)))]
    for core in cores:
        core.reset(np.arange(64), first_uniforms(0, 64))
        for _ in range(50):
            core.step(np.zeros((64, 1), np.float32))
    plain, other = cores
    still = other.episodes["turns"] == 0
    assert 16 < still.sum() < 48
    same = (plain.episodes["state"][:, :7] == other.episodes["state"][:, :7]).all(axis=1)
    assert same[still].all()
    assert same[~still].mean() < 0.5  # a bit that stands does not mind
    names = [channel.name for channel in other.critic.channels]
    shown = other.seen["privileged"][:, [names.index("tilt_cosine"), names.index("tilt_sine")]]
    assert not shown[still].any()
    assert shown[~still].any(axis=1).all()


def test_numbers_of_turns_and_angles_are_drawn_evenly():
    core = EpisodeBatch(3000, scenario={"tilt": {"turns": (1, 2, 5)}, "stick_slip": 0.0})
    core.reset(np.arange(3000), first_uniforms(0, 3000))
    counts = np.bincount(core.episodes["turns"].astype(int), minlength=6)[[1, 2, 5]]
    assert np.abs(counts - 1000).max() < 130
    assert stats.kstest(core.episodes["state"][:, 7] / (2.0 * np.pi), "uniform").pvalue > 1e-3


def wandered(wandering, steps, rigs=400):
    """Logarithms by which coefficients have wandered from their values, shape (steps + 1, rigs, 3)."""
    core = EpisodeBatch(rigs, scenario={"wandering": wandering, "stick_slip": 0.0, "steady": 1.0}, duration=0.1 * steps)
    core.reset(np.arange(rigs), first_uniforms(0, rigs))
    base = core.episodes["coefficients"].copy()
    found = []
    for k in range(steps + 1):
        if k:
            core.step(np.zeros((rigs, 1), np.float32))
        e = core.episodes
        ratios = e["mu_k"] / base[:, 1], (e["mu_s"] - e["mu_k"]) / (base[:, 0] - base[:, 1]), e["v_b"] / base[:, 2]
        found.append(np.log(np.stack(ratios, axis=1)))
    return np.array(found)


def test_friction_wanders_with_the_deviation_and_the_time_that_were_asked_for():
    logs = wandered(Wandering(0.3, 2.0), 60)
    for k in (0, 1, 30, 60):  # stationary from the start on, normal, each by itself
        for i in range(3):
            assert stats.kstest(logs[k, :, i] / 0.3, "norm").pvalue > 1e-3
        assert np.abs(np.corrcoef(logs[k].T) - np.eye(3)).max() < 0.2
    flat = logs.reshape(61, -1)
    for lag in (1, 10, 20):
        shares = np.mean(flat[:-lag] * flat[lag:]) / 0.3**2
        assert shares == pytest.approx(np.exp(-0.1 * lag / 2.0), abs=0.05)


def test_friction_wanders_apart_from_the_noise_of_the_measurements():
    quiet, noisy = (
        played({"wandering": {}}, 30, None, sensors="surface", noise=noise, duration=5.0) for noise in (0.0, 1.0)
    )
    np.testing.assert_array_equal(quiet["mu_k"], noisy["mu_k"])
    assert len(set(quiet["mu_k"])) == 31


def test_a_target_steps_once_to_a_draw_of_its_own_and_the_info_says_so():
    env = gym.make(
        "DrillRig-v0",
        scenario={"target_step": 1.0, "target_time": (0.5, 0.5), "speed_target": (1.0, 4.0)},
        duration=6.0,
    )
    observation, info = env.reset(seed=4)
    place = env.unwrapped.sensors.names.index("speed_target")
    targets, shown = [info["speed_target"]], [observation[place]]
    for _ in range(60):
        observation, _, _, _, info = env.step(np.zeros(1, np.float32))
        targets.append(info["speed_target"])
        shown.append(observation[place])
    assert len(set(targets[:31])) == len(set(targets[31:])) == 1 != len(set(targets))
    np.testing.assert_allclose(shown, (np.array(targets) - 3.0) / 2.0, atol=1e-6)
    core = EpisodeBatch(2000, scenario={"target_step": 0.3, "stick_slip": 0.0})
    core.reset(np.arange(2000), first_uniforms(0, 2000))
    times = core.episodes["target_time"]
    assert np.isfinite(times).mean() == pytest.approx(0.3, abs=0.04)
    assert stats.kstest((times[np.isfinite(times)] / 60.0 - 0.2) / 0.4, "uniform").pvalue > 1e-3
    assert stats.kstest((core.episodes["next_target"] - 1.0) / 4.0, "uniform").pvalue > 1e-3
    assert abs(np.corrcoef(core.episodes["next_target"], core.episodes["speed_target"])[0, 1]) < 0.1


def test_the_operator_asks_for_another_speed():
    env = gym.make("DrillRig-v0", scenario="nominal").unwrapped
    env.reset(seed=0)
    env.set_target(4.5)
    observation, _, _, _, info = env.step(np.zeros(1, np.float32))
    assert info["speed_target"] == 4.5
    assert env.sensors.value(observation, "speed_target") == pytest.approx(4.5)
    assert info["reward_tracking"] == pytest.approx(
        -(((env.sensors.value(observation, "bit_speed_mean") - 4.5) / 4.5) ** 2), rel=1e-4
    )
    many = gym.make_vec("DrillRig-v0", num_envs=3)
    many.reset(seed=0)
    many.set_target(np.array([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(many.step(np.zeros((3, 1), np.float32))[4]["speed_target"], [1.0, 2.0, 3.0])
    training = make_sb3(2)
    training.reset()
    training.env_method("set_target", 2.5)
    assert np.all(training.core.episodes["speed_target"] == 2.5)
    training.env_method("set_target", [1.5, 2.0])
    assert training.core.episodes["speed_target"].tolist() == [1.5, 2.0]
    env.reset(seed=1)
    assert env.core.episodes["speed_target"][0] != 4.5


@pytest.mark.parametrize(("method", "value"), [("set_target", 2.5), ("change", "wide")])
def test_some_rigs_of_a_batch_cannot_be_asked_for_another_speed_or_scenario(method, value):
    training = make_sb3(3)
    training.reset()
    before, scenario = training.core.episodes["speed_target"].copy(), training.scenario
    arguments = {"scenario": value} if method == "change" else {"speed_target": value}
    with pytest.raises(ValueError, match=f"env_method: {method} for some rigs only is not allowed; allowed: for all"):
        training.env_method(method, indices=[0], **arguments)
    np.testing.assert_array_equal(training.core.episodes["speed_target"], before)
    assert training.scenario is scenario


@pytest.mark.parametrize(
    "make",
    [
        lambda: gym.make("DrillRig-v0").unwrapped,
        lambda: gym.make_vec("DrillRig-v0", num_envs=2),
        lambda: make_sb3(2),
    ],
)
def test_before_the_first_episode_nobody_can_be_asked_for_a_speed(make):
    env = make()
    with pytest.raises(ResetNeeded, match="no episode has begun"):
        env.set_target(2.0)
    env.reset()
    env.set_target(2.0)


def test_no_draw_lets_friction_wander_to_infinity():
    uniforms = np.full((2, UNIFORMS), 1.0 - 2.0**-53)
    uniforms[1] = 0.0
    draws = draw_episodes(Scenario(wandering=Wandering(2.0), spread=0.0), uniforms, 60.0, {})
    assert np.abs(draws.logarithms / 2.0).max() == pytest.approx(5.66, abs=0.01)
    np.testing.assert_allclose(draws.logarithms[0], -draws.logarithms[1], rtol=1e-6)


@pytest.mark.parametrize(
    ("target", "words"),
    [
        (0.0, "speed_target = 0.0 rad/s is not allowed; allowed: >= 0.01 and <= 10"),
        (11.0, "speed_target = 11.0 rad/s is not allowed"),
        (np.nan, "speed_target = nan rad/s is not allowed"),
        ("4", "is text"),
        ([1.0, 2.0], r"shape of speed_target = \(2,\) is not allowed; allowed: \(\), or \(1,\)"),
    ],
)
def test_a_target_that_is_not_allowed_is_refused(target, words):
    env = gym.make("DrillRig-v0").unwrapped
    env.reset(seed=0)
    with pytest.raises(ValueError, match=words):
        env.set_target(target)


def test_what_a_course_gives_cannot_be_pinned_or_asked_for():
    course = {"time": [0.0], "normal_force": [5.0], "speed_target": [3.0]}
    env = gym.make("DrillRig-v0", scenario={"course": course}).unwrapped
    for pin in ({"normal_force": 3.0}, {"load_steps": []}, {"speed_target": 2.0}):
        with pytest.raises(
            ValueError, match="cannot be pinned, the scenario's course gives normal_force, speed_target"
        ):
            env.reset(options=pin)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="the scenario's course gives the target"):
        env.set_target(2.0)
    with pytest.raises(ValueError, match=r"speed_target = 12\.0 rad/s is not allowed"):
        Task(scenario={"course": {"time": [0.0, 1.0], "speed_target": [3.0, 12.0]}})


def test_a_scenario_that_varies_can_be_given_and_taken_while_an_environment_lives():
    env = gym.make("DrillRig-v0").unwrapped
    for scenario in ({"course": {"time": [0.0], "normal_force": [7.0]}}, "default"):
        env.change(scenario=scenario)
        env.reset(seed=0)
        expected = gym.make("DrillRig-v0", scenario=scenario).unwrapped
        expected.reset(seed=0)
        for _ in range(5):
            left, right = (one.step(np.ones(1, np.float32)) for one in (env, expected))
            np.testing.assert_array_equal(left[0], right[0])
            assert left[4] == right[4]


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"wandering": {"deviation": 0.0}}, "deviation = 0.0 is not allowed; allowed: > 0 and <= 2"),
        ({"wandering": {"time": -1.0}}, "time = -1.0 s is not allowed"),
        ({"wandering": 3}, "wandering = 3 is not allowed"),
        ({"tilt": {"share": 2.0}}, "share = 2.0 is not allowed"),
        ({"target_step": 1.5}, "target_step = 1.5 is not allowed"),
        ({"target_time": (0.5, 1.5)}, r"target_time = \(0.5, 1.5\) is not allowed"),
        ({"course": {"time": [0.0]}}, "what is given = nothing"),
    ],
)
def test_what_does_not_vary_so_is_refused(fields, words):
    with pytest.raises(ValueError, match=words):
        Scenario.named(fields)


def test_signals_of_a_run_on_a_tilted_disc_go_together():
    run = simulate(friction=Friction(20.0), speed_reference=3.0, duration=5.0, tilt=Tilt(0.4, 2))
    assert set(run.signals()) == set(SIGNALS)
    np.testing.assert_array_equal(run.friction_torque, Friction(run.normal_force).torque(run.rig, run.bit_speed))
