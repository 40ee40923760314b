"""A rig whose drive runs away is no environment; a rig that is hard to compute is one."""

import re

import gymnasium as gym
import numpy as np
import pytest

import baselines
import drillrig_env
from drillrig_env import Drive, Friction, Rig, simulate
from drillrig_env.env.task import Task
from tests.rigs import FAST, SOFT, STEADY_AND_WINDOW, TWO_WINDOWS, scaled

RUNAWAYS = [
    ({"rig": TWO_WINDOWS}, "k_p = 0 V s/rad with k_i = 0.524 V/rad"),
    ({"rig": {"k_i": 5e4}}, "k_p = 3 V s/rad with k_i = 50000 V/rad"),
    ({"rig": {"k_p": 0.2, "k_i": 9e2, "L": 0.3, "J_3": 8e-4}}, "k_p = 0.2 V s/rad with k_i = 900 V/rad"),
    ({"drive": Drive(0.0, 55.0, back_emf_share=1.0)}, "k_p = 0 V s/rad with k_i = 55 V/rad"),
]


@pytest.mark.parametrize(("given", "said"), RUNAWAYS, ids=[said for _, said in RUNAWAYS])
def test_a_drive_that_runs_away_is_told_with_gains_that_do_not(given, said):
    with pytest.raises(ValueError, match=re.escape(f"DrillRig: {said} lets the drive of this rig run away")) as error:
        Task.of(**given)
    gains = {
        name: float(value)
        for name, value in re.findall(r"(k_[pi]) = ([\d.e+-]+)", str(error.value).split("such as")[1])
    }
    rig = Rig.of(given.get("rig"))
    own = given.get("drive") or Drive.of_rig(rig)
    drive = Drive(gains.get("k_p", own.k_p), gains["k_i"], own.back_emf_share)
    task = Task(rig=rig, drive=drive)
    env = gym.make("DrillRig-v0", task=task)
    env.reset(seed=0)
    for _ in range(task.steps):
        observation = env.step(np.zeros(1, np.float32))[0]
    assert np.all(np.isfinite(observation))


@pytest.mark.parametrize(
    "make",
    [
        lambda **given: gym.make("DrillRigSurface-v0", **given),
        lambda **given: gym.make_vec("DrillRig-v0", num_envs=2, **given),
        lambda **given: drillrig_env.make_sb3(2, **given),
        lambda **given: baselines.ZTorque(**given),
    ],
    ids=["one", "vector", "sb3", "baseline"],
)
def test_every_form_refuses_it_and_simulate_shows_it(make):
    with pytest.raises(ValueError, match="lets the drive of this rig run away"):
        make(rig=TWO_WINDOWS)
    run = simulate(TWO_WINDOWS, Friction(0.0), speed_reference=2.0, duration=80.0)
    assert np.abs(run.top_speed[run.time > 60.0]).max() > 100.0


def test_a_drive_of_its_own_may_tame_a_rig():
    assert Task(rig=TWO_WINDOWS, drive=Drive(0.1, 0.001)).drive == Drive(0.1, 0.001)


def test_a_rig_without_any_damping_is_told_so():
    undamped = {"k_p": 0.0, "K_E": 0.0, "d_1": 0.0, "d_2": 0.0, "C_m": 0.0}
    with pytest.raises(ValueError, match=r"needs damping in the string or the motor$"):
        Task(rig=Rig(**undamped))


@pytest.mark.parametrize(
    "rig",
    [
        Rig(),
        FAST,
        SOFT,
        scaled(time=2.0**20, torque=2.0**-30),
        Rig(L=1e-12, k_1=1e9),
        Rig(**STEADY_AND_WINDOW),
        Rig(d_1=0.0, d_2=0.0, C_m=0.0),
        Rig(k_i=1e-9),
    ],
    ids=["chapter", "fast", "soft", "scaled", "stiff", "window", "undamped", "hardly any integral"],
)
def test_rigs_that_turn_steadily_are_taken(rig):
    assert Task(rig=rig).rig == rig
