"""Policies that go by a friction of the nominal rig: the one that they are given, or the chapter's."""

import gymnasium as gym
import numpy as np
import pytest

from baselines import LQG, FeedForwardStart, JumpEaseEstimated
from drillrig_env import Friction, Scenario, Task
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.evaluation.runner import play
from drillrig_env.policy import context_of, load
from drillrig_env.scales import Scales
from tests.rigs import scaled


def references(policy, steps=60):
    core = EpisodeBatch(4, rig=policy.rig, duration=steps * policy.task.control_period)
    core.reset(np.arange(4), first_uniforms(0, 4), {"start": "stick_slip", "normal_force": 15.0, "load_steps": []})
    for _ in play(policy, core):
        pass
    return core.episodes["speed_reference"].copy()


@pytest.mark.parametrize("law", [LQG, JumpEaseEstimated])
def test_the_chapters_friction_is_what_is_gone_by_without_one(law):
    np.testing.assert_array_equal(references(law()), references(law(friction=Friction(7.0))))


@pytest.mark.parametrize("law", [LQG, JumpEaseEstimated])
def test_another_friction_makes_another_law(law):
    assert np.abs(references(law()) - references(law(friction=Friction(10.0, 0.5, 0.2, 0.5)))).max() > 1e-3


def test_a_friction_is_counted_in_the_scales_of_the_rig():
    rig = scaled(4.0, 0.5)
    nominal = LQG(rig=rig, friction=Scales.of(rig).friction).nominal_friction
    chapter = Friction(1.0)
    assert (nominal.normal_force, nominal.mu_s, nominal.mu_k, nominal.v_b) == (1.0, chapter.mu_s, chapter.mu_k, 1.0)


def test_a_law_that_cannot_be_planned_with_is_refused():
    assert LQG(friction=Friction(law="gaussian")).nominal_friction.law == "gaussian"
    for law in (FeedForwardStart, JumpEaseEstimated):
        with pytest.raises(ValueError, match=f"{law.__name__}: law of the friction = 'gaussian' is not allowed"):
            law(friction=Friction(law="gaussian"))


def test_a_policy_for_an_environment_goes_by_its_friction():
    assert "friction" not in context_of(Task(rig=scaled(4.0, 0.5), scenario="wide"))
    assert load("lqg", gym.make("DrillRig-v0", scenario=Scenario(friction=Friction(25.0)))).friction is None
    friction = Friction(10.0, 0.5, 0.2, 0.5)
    made = load("lqg", gym.make("DrillRig-v0", scenario=Scenario(friction=friction)))
    assert made.friction.falls_as(friction)
    assert not friction.falls_as(Friction(10.0, 0.5, 0.2, 0.5, law="gaussian"))
