"""Rigs beyond what can be computed are refused by name, before anything is computed."""

import gymnasium as gym
import pytest

from drillrig_env import Drive, Rig, simulate, simulate_batch
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
        ({"L": 1e-18}, "L = 1e-18 H"),
        ({"R": 1e30}, r"R = 1e\+30 ohm"),
        ({"k_p": 1e60}, r"k_p = 1e\+60 V s/rad"),
        ({"eta": 1e160}, r"eta = 1e\+160"),
        ({"k_i": 1e-200}, "k_i = 1e-200 V/rad"),
        ({"T_r2": 1e30}, r"T_r2 = 1e\+30 N m"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_rig_too_fast_or_too_large_is_refused_with_its_parameter(changes, words):
    rig = Rig(**changes)
    for refused in (simulate, simulate_batch, lambda rig: gym.make("DrillRig-v0", rig=rig)):
        with pytest.raises(ValueError, match=f"{words} is beyond what can be computed; allowed: a value with which"):
            refused(rig)


def test_drive_too_fast_is_refused_as_a_drive():
    with pytest.raises(ValueError, match=r"Drive: k_p = 1e\+50 V s/rad is beyond"):
        step_tables(Rig(), 0.1, drive=Drive(1e50, 1.0))
