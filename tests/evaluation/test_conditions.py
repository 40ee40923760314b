"""Under which conditions everyone competes, and what is said where an agent's training had others."""

import pytest

from drillrig_env.evaluation.conditions import Conditions, conditions_for

PLAIN = {"env_id": "DrillRig-v0", "env_kwargs": {}}
NOISY = {"env_id": "DrillRig-v0", "env_kwargs": {"noise": 2.0, "delay": [1, 5], "scenario": "wide", "duration": 30.0}}
SURFACE = {"env_id": "DrillRigSurface-v0", "env_kwargs": {}}


def test_standard_conditions_are_the_environments_own():
    for env_id, sensors, noise, delay in (
        ("DrillRig-v0", "state", 0.0, (0, 0)),
        ("DrillRigSurface-v0", "surface", 1.0, (1, 1)),
    ):
        found = Conditions.named(env_id)
        assert found.arguments == {"sensors": sensors, "noise": noise, "delay": delay}
        assert Conditions.named(found) is found


def test_without_agents_the_conditions_are_standard():
    assert conditions_for({}) == Conditions.of("DrillRig-v0")
    assert conditions_for({}, "DrillRigSurface-v0") == Conditions.of("DrillRigSurface-v0")


@pytest.mark.parametrize("env_id", [None, "DrillRig-v0"])
def test_noise_and_delay_of_a_training_hold_for_everyone_and_are_told(env_id):
    said = []
    found = conditions_for({"ppo_1": NOISY}, env_id, said.append)
    assert found.arguments == {"sensors": "state", "noise": 2.0, "delay": (1, 5)}
    (line,) = said
    assert (
        "ppo_1 was trained with the sensors of DrillRig-v0, noise 2.0, delay 1 to 5 steps, and so is everyone" in line
    )
    assert "scenario and duration of its own, which are not taken over" in line


def test_an_agents_environment_is_its_own_where_none_is_named():
    assert conditions_for({"ppo_surface": SURFACE}).env_id == "DrillRigSurface-v0"
    said = []
    assert conditions_for({"ppo_surface": SURFACE}, "DrillRig-v0", said.append) == Conditions.of("DrillRig-v0")
    assert said == [
        "ppo_surface was trained with the sensors of DrillRigSurface-v0, noise 1.0, delay 1 step, "
        "and meets the sensors of DrillRig-v0, noise 0.0, delay 0 steps"
    ]


def test_agents_of_different_trainings_meet_standard_conditions():
    said = []
    assert conditions_for({"a": NOISY, "b": PLAIN}, say=said.append) == Conditions.of("DrillRig-v0")
    (line,) = said
    assert line.startswith("a was trained with the sensors of DrillRig-v0, noise 2.0")
    assert "and meets the sensors of DrillRig-v0, noise 0.0" in line


def test_agents_of_different_environments_meet_the_first_that_shows_what_all_see():
    both = {"a": SURFACE, "b": {"env_id": "DrillRigUnknown-v0", "env_kwargs": {}}}
    assert conditions_for(both, say=lambda _: None) == Conditions.of("DrillRigSurface-v0")
    assert conditions_for({**both, "c": PLAIN}, say=lambda _: None) == Conditions.of("DrillRig-v0")  # none shows all


def test_a_training_under_standard_conditions_needs_no_word():
    said = []
    conditions_for({"b": PLAIN}, say=said.append)
    assert said == []
