"""The record of what an environment is: every way to give its fields, what they mean, and what is refused."""

import inspect
from dataclasses import fields, replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import drillrig_env
from drillrig_env import Drive, Reward, Rig, Scenario, Task
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.sensors import SENSORS, Sensors
from drillrig_env.env.single import DrillRigEnv
from drillrig_env.env.task import TASK_FIELDS
from drillrig_env.markdown import table
from drillrig_env.parameters import default_of

SOME = {
    "rig": {"k_p": 2.0},
    "scenario": "wide",
    "sensors": ("bit_speed", "speed_target"),
    "noise": {"bit_speed": 0.1},
    "delay": (1, 3),
    "reward": {"action": 0.5},
    "slew_limit": 1.5,
    "drive": (0.3, 0.2),
    "duration": 2.0,
}
FORMS = {
    "single": lambda **arguments: gym.make("DrillRig-v0", **arguments).unwrapped,
    "vector": lambda **arguments: gym.make_vec("DrillRig-v0", num_envs=2, **arguments),
    "sb3": lambda **arguments: drillrig_env.make_sb3(2, **arguments),
    "batch": lambda **arguments: EpisodeBatch(2, **arguments),
}


def test_fields_are_kept_as_records():
    task = Task.of(**SOME)
    assert task.rig == Rig(k_p=2.0)
    assert task.scenario is Scenario.named("wide")
    assert task.sensors == Sensors.named(("bit_speed", "speed_target"))
    assert task.reward == Reward(action=0.5)
    assert task.drive == task.speed_loop == Drive(0.3, 0.2)
    assert (task.delay, task.delays, task.steps) == ((1, 3), (1, 3), 20)
    assert Task.of({"duration": 2.0}, duration=3.0).duration == 3.0
    assert Task.of(task, duration=3.0) == replace(task, duration=3.0)


def test_what_is_not_given_is_the_rigs_and_the_sensors_own():
    task = Task.of(sensors="surface")
    assert task.delays == (1, 1)
    assert task.speed_loop == Drive.of_rig(Rig())
    assert Task.of(task, sensors="state").delays == (0, 0)
    assert Task.of(rig=None).rig == Rig()
    assert Task.of(reward=None).reward == Reward()


@pytest.mark.parametrize("form", FORMS)
def test_every_form_takes_a_task_its_fields_and_both(form):
    task = Task.of(**SOME)
    for env in (FORMS[form](task=task), FORMS[form](**SOME), FORMS[form](task={**SOME, "duration": 9.0}, duration=2.0)):
        for name in TASK_FIELDS:
            if name not in ("scenario", "rig", "sensors"):
                assert getattr(env, name) == getattr(task, name)
        assert (env.rig, env.task.scenario.spread) == (task.rig, task.scenario.spread)


def test_the_id_says_which_sensors_unless_they_are_given():
    assert gym.make("DrillRigSurface-v0", task=Task()).unwrapped.sensors is SENSORS["surface"]
    assert gym.make("DrillRigSurface-v0", sensors="encoders").unwrapped.sensors is SENSORS["encoders"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"task": {"rigg": Rig()}}, "unknown field 'rigg' of the task; did you mean rig"),
        ({"rig": [1.0]}, "rig = .* a dictionary of changes to Rig"),
        ({"rig": {"k_o": 1.0}}, "unknown key k_o"),
        ({"rig": "no_such.toml"}, "no file no_such.toml"),
        ({"scenario": 5}, "scenario = 5 is not allowed; allowed: nominal, default, wide"),
        ({"scenario": "defalt"}, "did you mean default"),
        ({"scenario": {"normal_force": 10}}, r"normal_force = 10 N .*\(low, high\)"),
        ({"scenario": {"spread": "0.1"}}, "spread = '0.1' is text"),
        ({"scenario": {"friction": {"mu_x": 0.5}}}, "unknown key mu_x"),
        ({"scenario": {"friction": {"mu_s": [0.5, 0.6]}}}, "friction"),
        ({"sensors": "statee"}, "did you mean state"),
        ({"sensors": 3}, "sensors = 3 is not allowed; allowed: state, encoders, surface"),
        ({"sensors": None}, "sensors = None is not allowed"),
        ({"sensors": ("bit_sped",)}, "did you mean bit_speed"),
        ({"noise": "loud"}, "noise = 'loud'"),
        ({"noise": float("nan")}, "noise = nan"),
        ({"noise": {"bit_speed": True}}, "bit_speed = True"),
        ({"delay": "1"}, "delay = '1'"),
        ({"delay": float("nan")}, "delay = nan"),
        ({"delay": True}, "delay = True"),
        ({"delay": (1, 2, 3)}, r"delay = \(1, 2, 3\)"),
        ({"reward": {"varianc": 1.0}}, "unknown key varianc = 1.0; did you mean variance"),
        ({"reward": lambda: 0.0}, "reward = <function"),
        ({"reward": {"variance": 1e300}}, "variance = 1e.300"),
        ({"reward": {"variance_shape": "cubic"}}, "variance_shape = 'cubic' .* 'square' or 'absolute'"),
        ({"reward": {"time_constant": 1e-300}}, "time_constant = 1e-300 s"),
        ({"slew_limit": 0.0}, "slew_limit = 0.0 rad/s"),
        ({"slew_limit": "2"}, "slew_limit = '2' is text"),
        ({"slew_limit": float("inf")}, "slew_limit = inf"),
        ({"drive": "12"}, "drive = '12'"),
        ({"duration": float("inf")}, "duration = inf s .* multiple of 0.1"),
        ({"duration": float("nan")}, "duration = nan s"),
        ({"duration": 0.05}, "duration = 0.05 s .* multiple of 0.1"),
        ({"duration": 1e300}, "duration = 1e.300 s"),
        ({"duration": "60"}, "duration = '60' s"),
        ({"task": Rig()}, "task = Rig.* a rig goes by the name rig"),
        ({"threads": 0}, "threads = 0"),
        ({"threads": 1.5}, "threads = 1.5"),
        ({"max_episode_steps": 0}, "max_episode_steps = 0"),
    ],
)
def test_what_is_not_allowed_is_refused_with_a_sentence(arguments, words):
    with pytest.raises((ValueError, FileNotFoundError), match=words):
        EpisodeBatch(1, **arguments)


@pytest.mark.parametrize("rigs", [0, -1, 1.5, True, "2", None])
def test_number_of_rigs_is_whole_and_positive(rigs):
    with pytest.raises(ValueError, match="number of rigs"):
        EpisodeBatch(rigs)


def test_former_name_of_the_drive_works_with_a_warning():
    with pytest.warns(DeprecationWarning, match="`drive_gains` is now `drive`"):
        task = Task.of(drive_gains=(0.3, 0.2))
    assert task.drive == Drive(0.3, 0.2)


def argument_table():
    """The table of the environment's arguments, from the documented fields of the task."""
    shown = {"rig": "`Rig()`", "scenario": '`"default"`', "sensors": "by id", "reward": "`Reward()`"}
    rows = []
    for item in fields(Task):
        meta, default = item.metadata, default_of(item)
        value = shown.get(item.name) or (meta["none"] if default is None else f"`{default}`")
        rows.append((f"`{item.name}`", value, meta["unit"], meta["meaning"], meta["allowed"]))
    return table(["Name", "Default", "Unit", "Meaning", "Allowed"], rows, words=5)


def test_docstring_and_page_hold_the_table_of_arguments():
    text = "\n".join(line.strip() for line in DrillRigEnv.__doc__.splitlines())
    page = (Path(__file__).parents[2] / "docs" / "environment.md").read_text(encoding="utf-8")
    assert argument_table() in text
    assert argument_table() in page


def test_every_field_has_a_meaning():
    for record in (Task, Reward, Scenario, Drive):
        assert all(item.metadata["meaning"] for item in fields(record))


def test_extreme_values_that_are_allowed_give_finite_rewards():
    env = gym.make("DrillRig-v0", reward={"variance": 1e6, "tracking": 1e6})
    env.reset(seed=0, options={"speed_target": 0.01, "normal_force": 30.0, "start": "rest"})
    rewards = [env.step(np.ones(1, np.float32))[1] for _ in range(100)]
    assert np.isfinite(rewards).all()


def test_page_holds_the_table_of_infos_of_the_docstring():
    page = (Path(__file__).parents[2] / "docs" / "environment.md").read_text(encoding="utf-8")
    rows = inspect.getdoc(DrillRigEnv).split("## Info\n")[1].split("## Arguments")[0].splitlines()
    table = [row for row in rows if row.startswith("|")]
    assert len(table) > 3
    assert "\n".join(table) in page
