"""Rigs beyond what can be computed are refused by name, before anything is computed."""

import re
from dataclasses import fields

import gymnasium as gym
import numpy as np
import pytest

from drillrig_env import Drive, Friction, Rig, simulate, simulate_batch
from drillrig_env.stepper.finite import NotFiniteError
from drillrig_env.stepper.tables import step_tables


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"J_1": 1e-300}, r"J_1 = 1e-300 kg m\^2"),
        ({"J_3": 1e-290}, r"J_3 = 1e-290 kg m\^2"),
        ({"k_1": 1e300}, r"k_1 = 1e\+300 N m/rad"),
        ({"k_2": 1e-310}, r"k_2 = 1e-310 N m/rad"),
        ({"d_1": 3e8}, r"d_1 = 3e\+08 N m s/rad"),
        ({"d_2": 1e200}, r"d_2 = 1e\+200 N m s/rad"),
        ({"L": 1e-40, "R": 1e-30}, "L = 1e-40 H"),
        ({"R": 1e30}, r"R = 1e\+30 ohm"),
        ({"k_p": 1e60}, r"k_p = 1e\+60 V s/rad"),
        ({"eta": 1e160}, r"eta = 1e\+160"),
        ({"eta": 5e-324}, r"eta = 4\.94066e-324"),
        ({"K_T": 2e-310}, r"K_T = 2e-310 N m/A"),
        ({"k_i": 1e-200}, "k_i = 1e-200 V/rad"),
        ({"T_r2": 1e30}, r"T_r2 = 1e\+30 N m"),
        ({"T_r2": 1.7e308}, r"T_r2 = 1\.7e\+308 N m"),
        ({"T_f": 1e200}, r"T_f = 1e\+200 N m"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_rig_too_fast_or_too_large_is_refused_with_its_parameter(changes, words):
    rig = Rig(**changes)
    for refused in (simulate, simulate_batch):
        with pytest.raises(ValueError, match=f"Rig: {words} is beyond what can be computed; allowed: a value"):
            refused(rig)
    with pytest.raises(ValueError, match=f"Rig: .*{' '.join(words.split()[:3])}.*; allowed: "):
        gym.make("DrillRig-v0", rig=rig)


def test_drive_too_fast_is_refused_as_a_drive():
    with pytest.raises(ValueError, match=r"Drive: k_p = 1e\+50 V s/rad is beyond"):
        step_tables(Rig(), 0.1, drive=Drive(1e50, 1.0))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", [item.name for item in fields(Rig)])
def test_any_value_of_a_parameter_gives_numbers_or_a_sentence_that_names_it(name):
    for value in (0.0, 5e-324, 3e-308, 2e-155, 7e-31, 4e-14, 6e13, 3e29, 8e153, 1.7e308, -2.0, np.inf, np.nan):
        words = _outcome(name, value)
        if words:
            named = rf"Rig: (slowest period with .*)?{name} = |Friction: normal_force = "
            away = "DrillRig: k_p = .* lets the drive of this rig run away.*; allowed: "
            assert re.match(rf"({named}).*allowed: |{away}|(simulate|step): .* of rig 0", words)


def _outcome(name, value):
    """What is said of a rig with this value; nothing where all its numbers are finite."""
    try:
        rig = Rig(**{name: value})
        states = simulate(rig, Friction(20.0), duration=0.3).state
        env = gym.make("DrillRig-v0", rig=rig)
        seen = env.reset(seed=2)[0], env.step(np.zeros(1, dtype=np.float32))[0]
    except (ValueError, NotFiniteError) as error:
        return str(error)
    return "" if np.isfinite(states).all() and np.isfinite(seen).all() else "not finite"


def test_armature_faster_than_any_step_is_one_without_lag():
    fast, faster = (simulate(Rig(L=L), Friction(18.0), duration=5.0).state for L in (1e-12, 2e-310))
    np.testing.assert_allclose(faster, fast, atol=1e-9)


def test_friction_torque_beyond_doubles_is_refused_as_friction():
    for run in (simulate, simulate_batch):
        with pytest.raises(
            ValueError, match=r"Friction: normal_force = 1\.7e\+308 N is not allowed; allowed: <= 3\.6e\+306 N"
        ):
            run(Rig(r_1=100.0), Friction(1.7e308), duration=1.0)
