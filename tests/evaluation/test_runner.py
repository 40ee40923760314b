"""A run shows what the environment shows, and asks of a policy what its contract says."""

from dataclasses import replace

import numpy as np
import pytest

from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.scenario import Scenario
from drillrig_env.evaluation.runner import play, run
from drillrig_env.evaluation.suites import Suite, suite
from drillrig_env.stepper.finite import NotFiniteError


class Wave:
    """Actions that depend on the step alone; keeps what it was given."""

    def __init__(self, size=0.5):
        self.size, self.begins, self.seen = size, [], []

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        step = 0 if state is None else state[0]
        self.begins.append(np.asarray(episode_start).copy())
        self.seen.append(observation.copy())
        assert deterministic
        return np.full((len(observation), 1), self.size * np.cos(0.3 * step), np.float32), (step + 1,)


SMALL = Suite(
    "small",
    "two kinds of rigs",
    Scenario.named("nominal"),
    (
        (2, {"start": "steady", "normal_force": 5.0, "load_steps": []}),
        (1, {"start": "steady", "speed_target": 2.0, "load_steps": [(0.5, 20.0)]}),
    ),
    {"slew_limit": 1.5},
    first_seed=11,
)


def test_traces_are_the_records_after_each_control_step():
    episodes = run(Wave(), SMALL, duration=2.0)
    core = EpisodeBatch(3, scenario="nominal", slew_limit=1.5, duration=2.0)
    core.reset(np.arange(2), first_uniforms(11, 2), SMALL.groups[0][1])
    core.reset(np.arange(2, 3), first_uniforms(13, 1), SMALL.groups[1][1])
    for step in range(20):
        core.step(np.full((3, 1), 0.5 * np.cos(0.3 * step), np.float32))
        for name in ("lowest", "highest", "average", "stuck", "highest_torque", "speed_reference", "reward"):
            np.testing.assert_array_equal(getattr(episodes, name)[:, step], core.episodes[name])
        np.testing.assert_array_equal(episodes.top_speed[:, step], core.episodes["state"][:, 4])
    assert episodes.lowest.shape == (3, 20)
    np.testing.assert_array_equal(episodes.friction.normal_force, [5.0, 5.0, 20.0])  # as the episode ends
    assert episodes.start.tolist() == ["steady"] * 3
    assert episodes.speed_target[2] == 2.0


class Exact(Wave):
    sensors, exact = ("bit_speed", "twist_12", "speed_target"), True


def test_who_is_exact_is_shown_its_channels_without_noise_and_delay():
    policy, noisy = Exact(), replace(SMALL, env={**SMALL.env, "noise": 1.0, "delay": 2})
    run(policy, noisy, sensors="surface", duration=1.0)
    core = EpisodeBatch(3, scenario="nominal", slew_limit=1.5, duration=1.0, sensors=Exact.sensors, noise=0.0)
    core.reset(np.arange(2), first_uniforms(11, 2), SMALL.groups[0][1])
    core.reset(np.arange(2, 3), first_uniforms(13, 1), SMALL.groups[1][1])
    for step in range(10):
        np.testing.assert_array_equal(policy.seen[step], core.observations)
        core.step(np.full((3, 1), 0.5 * np.cos(0.3 * step), np.float32))


def test_policy_sees_the_begin_once_and_the_observations_before_each_step():
    policy = Wave()
    run(policy, SMALL, sensors="encoders", duration=1.0)
    assert [begin.tolist() for begin in policy.begins] == [[True] * 3] + [[False] * 3] * 9
    assert policy.seen[0].shape == (3, 5)
    assert not np.array_equal(policy.seen[0], policy.seen[1])


def test_suite_has_the_last_word_on_the_environment():
    """What a caller gives for slew limit and noise gives way to the suite; the rest is the caller's."""
    own = run(Wave(1.0), SMALL, duration=1.0, slew_limit=0.1)
    np.testing.assert_allclose(np.diff(own.speed_reference[:, :2]), 0.15 * np.cos(0.3), rtol=1e-6)


def test_progress_counts_to_the_end():
    told = []
    run(Wave(), SMALL, duration=0.5, progress=lambda done, of: told.append((done, of)))
    assert told == [(1, 5), (2, 5), (3, 5), (4, 5), (5, 5)]


class Privileged(Wave):
    privileged = ("normal_force",)

    def __init__(self):
        super().__init__()
        self.told = []

    def tell(self, info):
        self.told.append(info["normal_force"].copy())


def test_who_is_privileged_is_told_before_each_step():
    policy = Privileged()
    run(policy, SMALL, duration=1.0)
    assert len(policy.told) == 10
    assert policy.told[0].tolist() == [5.0, 5.0, 10.0]
    assert policy.told[-1].tolist() == [5.0, 5.0, 20.0]


class Wrong:
    def __init__(self, actions):
        self.actions = actions

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return self.actions, None


@pytest.mark.parametrize("actions", [np.zeros((2, 1)), np.zeros(4), np.full((3, 1), np.nan)])
def test_actions_of_another_shape_or_nan_are_refused(actions):
    with pytest.raises(ValueError, match="action"):
        run(Wrong(actions), SMALL, duration=1.0)


def test_play_yields_after_each_step():
    core = EpisodeBatch(2, scenario="nominal", duration=0.5)
    core.reset(np.arange(2), first_uniforms(0, 2), {"start": "steady"})
    assert [(step, int(core.episodes["step"][0])) for step in play(Wave(), core)] == [(k, k + 1) for k in range(5)]


def test_one_rig_of_a_suite_meets_the_same_episode_alone():
    chosen = suite("chapter")
    together, alone = run(Wave(), chosen, duration=20.0), run(Wave(), chosen.only(5), duration=20.0)
    np.testing.assert_array_equal(alone.average[0], together.average[5])


class Late:
    """Gives an impossible action to the third rig in the third step."""

    def __init__(self, value):
        self.value = value

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        step = 0 if state is None else state[0]
        actions = np.zeros((len(observation), 1), np.float32)
        actions[2, 0] = self.value if step == 2 else 0.0
        return actions, (step + 1,)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_an_action_that_is_not_finite_names_policy_rig_seed_and_step(value):
    with pytest.raises(ValueError, match=r"Late: the action for rig 2 \(seed 13\) in control step 3 is not finite"):
        run(Late(value), SMALL, duration=1.0)


def test_a_rig_that_is_no_longer_finite_names_policy_rig_seed_and_step():
    core = EpisodeBatch(3)
    core.reset(np.arange(3), first_uniforms(0, 3))
    steps = play(Wave(), core, first_seed=20)
    next(steps)
    core.episodes["state"][1, 2] = np.nan
    with pytest.raises(NotFiniteError, match=r"Wave, rig 1 \(seed 21\) in control step 2: .* is not finite"):
        next(steps)


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, "2"])
def test_an_odd_number_of_threads_is_refused(threads):
    with pytest.raises(ValueError, match="threads = "):
        run(Wave(), SMALL, threads=threads)
