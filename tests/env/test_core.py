"""Rules of the episode: starts, loads, reward, window and verdict."""

import numpy as np
import pytest

from drillrig_env import Friction, Reward, Rig, make_sb3, simulate
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.vector import DrillRigVectorEnv
from drillrig_env.model import steady_state
from drillrig_env.verdict import is_mitigated

HOLD = np.zeros((1, 1), dtype=np.float32)


def begin(options, **arguments):
    core = EpisodeBatch(1, scenario="nominal", **arguments)
    core.reset(np.array([0]), first_uniforms(1, 1), options)
    return core


def run(core, steps, action=0.0):
    rows = []
    for _ in range(steps):
        core.step(np.full((1, 1), action, dtype=np.float32))
        rows.append(core.episodes[0].copy())
    return np.array(rows)


def test_steps_are_the_simulation():
    core = begin({"start": "rest", "normal_force": 20.0})
    rows = run(core, 60, action=0.25)
    references = [(0.1 * k, min(0.05 * (k + 1), 10.0)) for k in range(60)]
    expected = simulate(friction=Friction(20.0), speed_reference=references, duration=6.0, sample_period=0.1)
    np.testing.assert_allclose(rows["state"][:, :7], expected.state[1:], atol=1e-9)
    np.testing.assert_allclose(rows["speed_reference"], expected.speed_reference[:-1])


def test_reference_moves_at_the_slew_limit_and_stays_in_bounds():
    core = begin({"start": "steady", "speed_target": 4.0})
    assert np.allclose(np.diff(run(core, 40, action=3.0)["speed_reference"]).max(), 0.2)
    assert core.episodes["speed_reference"][0] == 10.0
    run(core, 60, action=-1.0)
    assert core.episodes["speed_reference"][0] == 0.0


def test_stick_slip_start_is_on_the_cycle_at_its_phase():
    core = EpisodeBatch(40, scenario="nominal")
    options = {"start": "stick_slip", "normal_force": 20.0, "speed_target": 2.0}
    core.reset(np.arange(40), first_uniforms(0, 40), options)
    assert core.starts(np.arange(40)) == ["stick_slip"] * 40
    speeds = core.episodes["state"][:, 2].copy()
    assert np.mean(speeds < 0.01) == pytest.approx(0.2, abs=0.15)  # it sticks for a fifth of its period
    assert speeds.max() > 4.0
    for x in core.episodes["state"][:5, :7]:
        cycle = simulate(friction=Friction(20.0), initial_state=x, speed_reference=2.0, duration=60)
        assert cycle.bit_speed[:300].max() == pytest.approx(cycle.bit_speed[-300:].max(), abs=2e-3)


def test_stick_slip_start_above_the_fold_is_steady_rotation():
    core = begin({"start": "stick_slip", "normal_force": 10.0, "speed_target": 3.2})
    assert core.starts(np.array([0])) == ["steady"]
    np.testing.assert_allclose(core.episodes["state"][0, :7], steady_state(Rig(), Friction(10.0), 3.2))
    below = begin({"start": "stick_slip", "normal_force": 10.0, "speed_target": 2.8})
    assert below.starts(np.array([0])) == ["stick_slip"]


def test_load_step_takes_effect_at_the_first_control_step_from_its_time_on():
    core = begin({"start": "steady", "speed_target": 4.0, "load_steps": [(0.25, 5.0), (0.5, 7.0), (0.5001, 9.0)]})
    forces = run(core, 8)["normal_force"].tolist()
    assert forces == [10.0, 10.0, 10.0, 5.0, 5.0, 7.0, 9.0, 9.0]


@pytest.mark.parametrize("shape", ["square", "absolute"])
def test_reward_follows_its_formula(shape):
    shapes = {"tracking_shape": shape, "variance_shape": shape}
    reward = Reward(variance=2.0, tracking=3.0, action=0.5, time_constant=1.0, **shapes)
    core = begin({"start": "stick_slip", "normal_force": 20.0, "speed_target": 2.0}, reward=reward)
    start = core.episodes[0].copy()
    rows = run(core, 30, action=0.4)
    references = [(0.1 * k, reference) for k, reference in enumerate(rows["speed_reference"].tolist())]
    fine = simulate(
        friction=Friction(20.0),
        initial_state=start["state"][:7],
        speed_reference=references,
        duration=3.0,
        sample_period=0.1 / 16,
    )
    mean, variance, gain = start["mean"], start["variance"], 1 - np.exp(-0.1 / 16)
    for speed in fine.bit_speed[1:]:
        mean, variance = (1 - gain) * mean + gain * speed, (1 - gain) * (variance + gain * (speed - mean) ** 2)
    error = (mean - 2.0) / 2.0
    tracking = error**2 if shape == "square" else abs(error)
    swing = variance / 4.0 if shape == "square" else np.sqrt(variance) / 2.0
    expected = [-2.0 * swing, -3.0 * tracking, -0.5 * 0.16]
    np.testing.assert_allclose(rows["terms"][-1], expected, rtol=1e-5)
    assert rows["reward"][-1] == pytest.approx(sum(expected), rel=1e-5)


@pytest.mark.parametrize("reward", [None, "phases"])
def test_calm_rotation_at_the_target_scores_zero(reward):
    core = begin({"start": "steady", "speed_target": 4.0}, reward=reward)
    assert np.abs(run(core, 100)["reward"]).max() < 1e-12


def test_reward_in_phases_is_made_of_the_running_statistics():
    core = begin({"start": "stick_slip", "normal_force": 20.0, "speed_target": 2.0}, reward="phases")
    row = run(core, 30, action=0.4)[-1]
    swing = np.sqrt(row["variance"]) / row["mean"]
    error = abs(row["mean"] - 2.0) / 2.0
    calm, on = 1.0 / (1.0 + (swing / 0.07) ** 2), 1.0 / (1.0 + (error / 0.05) ** 2)
    expected = [-0.1 * (1.0 - calm + swing / 2.0), -0.2 * (1.0 - calm * on + error / 10.0), -0.003 * 0.16]
    np.testing.assert_allclose(row["terms"], expected, rtol=1e-6)


def test_verdict_looks_at_the_last_ten_seconds():
    core = begin({"start": "stick_slip", "normal_force": 20.0, "speed_target": 3.5})
    rows = run(core, 200, action=0.0)
    rows = np.concatenate([rows, run(core, 25, action=1.0), run(core, 75), run(core, 25, action=-1.0), run(core, 275)])
    tail = rows[-100:]
    verdict = is_mitigated(tail["lowest"].min(), tail["highest"].max(), tail["average"].mean(), 3.5)
    assert core.ended[0]
    assert bool(core.mitigated[0]) == bool(verdict) is True
    stuck = begin({"start": "stick_slip", "normal_force": 20.0, "speed_target": 3.5})
    run(stuck, 600)
    assert not stuck.mitigated[0]


def test_impossible_arguments_are_refused():
    for arguments, word in (
        ({"num_rigs": 0}, "number of rigs"),
        ({"slew_limit": 0.0}, "rad/s"),
        ({"duration": 0.05}, "multiple of 0.1"),
        ({"sensors": "statee"}, "did you mean state"),
        ({"threads": 0}, "threads"),
    ):
        with pytest.raises(ValueError, match=word):
            EpisodeBatch(**arguments)
    for name in ("tracking_shape", "variance_shape"):
        with pytest.raises(ValueError, match=name):
            Reward(**{name: "cubic"})


def test_the_former_name_of_the_episodes_works_and_warns():
    core = EpisodeBatch(2)
    with pytest.warns(DeprecationWarning, match=r"core\.episodes"):
        assert core.rigs is core.episodes


@pytest.mark.parametrize(("rigs", "threads", "shared"), [(1, 2, False), (400, 1, False), (400, 2, True), (2, 3, True)])
def test_steps_of_several_rigs_are_shared_out_to_several_threads(monkeypatch, rigs, threads, shared):
    asked = []

    def watched(kernel, count, most, periods=1):
        asked.append((count, most))
        kernel(slice(0, count))

    core = EpisodeBatch(rigs, scenario="nominal", threads=threads)
    core.reset(np.arange(rigs), first_uniforms(1, rigs), {"start": "steady"})
    monkeypatch.setattr("drillrig_env.env.core.over_slices", watched)
    core.step(np.zeros((rigs, 1), np.float32))
    assert asked == [(rigs, threads)] * shared
    assert (core.episodes["step"] == 1).all()


def test_one_rig_is_made_where_no_number_is_given():
    assert [len(EpisodeBatch()), DrillRigVectorEnv().num_envs, make_sb3().num_envs] == [1, 1, 1]
