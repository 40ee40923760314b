"""Sampling predictive control: it frees and holds where the bare drive cannot, and repeats exactly."""

import gymnasium as gym
import numpy as np
import pytest

from baselines.constant import Constant
from baselines.mppi import INTERVAL, MPPI
from baselines.set_point_feedback import SIZE, SetPointFeedback, wanted_change
from drillrig_env import Friction, Rig
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.model import steady_state
from drillrig_env.stability import critical_speed


def play(policy, duration, **options):
    """One episode of the chapter's rig; its info at the end."""
    env = gym.make("DrillRig-v0", scenario="nominal", duration=duration)
    observation, info = env.reset(seed=0, options=options)
    state, start = None, np.array([True])
    while True:
        policy.tell(info)
        action, state = policy.predict(observation, state, start)
        start = np.array([False])
        observation, _, _, truncated, info = env.step(action)
        if truncated:
            return info


@pytest.fixture
def batch():
    """Six default rigs in stick-slip."""
    core = EpisodeBatch(6, threads=1)
    core.reset(np.arange(6), first_uniforms(500_000_000, 6), {"start": "stick_slip", "load_steps": []})
    return core


def actions_of(policy, core, steps):
    """Actions of a policy over the first steps of a batch, shape (steps, n)."""
    state, start, taken = None, np.ones(len(core), dtype=bool), []
    for _ in range(steps):
        policy.tell(core.info())
        actions, state = policy.predict(core.observations, state, start)
        start = np.zeros(len(core), dtype=bool)
        core.step(actions)
        taken.append(actions[:, 0])
    return np.array(taken)


@pytest.mark.parametrize(("normal_force", "target"), [(20.0, 2.0), (28.0, 1.3)])
def test_frees_a_rig_from_stick_slip_and_holds_it_below_the_critical_speed(normal_force, target):
    assert target < critical_speed(Rig(), Friction(normal_force))
    case = {"normal_force": normal_force, "speed_target": target, "start": "stick_slip"}
    assert not play(Constant(), 25.0, **case)["is_success"]
    assert play(MPPI(samples=8, threads=1), 25.0, **case)["is_success"]


def test_keeps_out_of_stick_slip_under_a_load_step_that_it_is_not_warned_of():
    case = {"normal_force": 10.0, "speed_target": 2.5, "start": "steady", "load_steps": [(3.0, 25.0)]}
    assert not play(Constant(), 20.0, **case)["is_success"]
    assert play(MPPI(samples=8, threads=1), 20.0, **case)["is_success"]


def test_feedback_alone_holds_rotation_that_a_constant_reference_loses():
    """From 5 % off the target, at 5.6 times the friction slope that the bare drive can bear."""
    friction, target, rig = Friction(28.0), 1.3, Rig()
    row = SetPointFeedback([rig], effort=30.0).at(friction, np.array([target]))
    assert row.shape == (1, SIZE + 1)
    held = {}
    for follows in (True, False):
        core = EpisodeBatch(1, scenario="nominal", duration=20.0, threads=1)
        core.reset(
            np.array([0]),
            first_uniforms(0, 1),
            {"normal_force": 28.0, "speed_target": target, "start": "steady"},
        )
        core.episodes["state"][:, :7] = steady_state(rig, friction, 1.05 * target)
        while not core.ended[0]:
            change = (
                wanted_change(row, core.episodes["state"], core.episodes["speed_reference"]) if follows else np.zeros(1)
            )
            core.step((change / 0.2).astype(np.float32)[:, None])
        held[follows] = bool(core.mitigated[0])
    assert held == {True: True, False: False}


def test_feedback_asks_for_no_change_in_steady_rotation_at_the_set_point():
    friction, speeds = Friction(np.array([0.0, 10.0, 30.0, 80.0])), np.array([3.0, 1.0, 2.0, 0.5])
    rows = SetPointFeedback([Rig()], effort=30.0).at(friction, speeds)
    np.testing.assert_allclose(wanted_change(rows, steady_state(Rig(), friction, speeds), speeds), 0.0, atol=1e-12)
    too_fast = steady_state(Rig(), Friction(10.0), np.full(4, 5.0))
    assert np.all(wanted_change(rows, too_fast, np.full(4, 5.0)) < 0.0)


def test_a_run_repeats_exactly_and_another_seed_does_not(batch):
    before = batch.episodes.copy(), batch.observations.copy()
    runs = []
    for seed in (0, 0, 1):
        batch.episodes[:], batch.observations = before[0], before[1]
        runs.append(actions_of(MPPI(samples=8, threads=1, seed=seed), batch, 12))
    np.testing.assert_array_equal(runs[0], runs[1])
    assert np.any(runs[0] != runs[2])


def test_a_rig_does_the_same_in_a_batch_as_alone_and_whenever_its_episode_began(batch):
    together, alone = MPPI(samples=8, threads=1), MPPI(samples=8, threads=1)
    state, state_alone = None, None
    for step in range(3 * INTERVAL):
        info = batch.info()
        together.tell(info)
        begins = np.full(6, step == 0)
        begins[1] |= step == 3  # out of step with the others from here on
        actions, state = together.predict(batch.observations, state, begins)
        alone.tell({name: info[name][1] for name in MPPI.privileged})
        action, state_alone = alone.predict(batch.observations[1], state_alone, begins[1:2])
        np.testing.assert_array_equal(action, actions[1])
        batch.step(actions)


def test_told_the_delay_it_acts_as_if_there_were_none():
    taken = []
    for delay in (0, 4):
        core = EpisodeBatch(1, scenario="nominal", delay=delay, threads=1)
        pins = {"normal_force": 20.0, "speed_target": 2.0, "start": "stick_slip"}
        core.reset(np.array([0]), first_uniforms(0, 1), pins)
        policy, state, references = MPPI(samples=8, threads=1), None, []
        for _ in range(20):
            policy.tell({**core.info(), "delay": np.array([delay])})
            actions, state = policy.predict(core.observations, state)
            core.step(actions)
            references.append(core.episodes["speed_reference"][0])
        taken.append(references)
    assert np.ptp(taken[0]) > 0.5
    np.testing.assert_allclose(taken[0], taken[1], atol=1e-3)


def test_clear_errors():
    with pytest.raises(ValueError, match=r"MPPI reads .*bit_speed_deviation.* do not show"):
        MPPI(sensors="encoders")
    with pytest.raises(RuntimeError, match=r"told normal_force, mu_s, mu_k, v_b: call tell"):
        MPPI(samples=0).predict(np.zeros((1, len(MPPI(samples=0).sensors.names)), np.float32))
    with pytest.raises(ValueError, match="samples = -1"):
        MPPI(samples=-1)
    with pytest.raises(ValueError, match="temperature = 0"):
        MPPI(temperature=0.0)
