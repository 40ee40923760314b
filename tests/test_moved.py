"""Modules that have moved work by their former names, and say so."""

import importlib
import pickle
import subprocess
import sys

import pytest

import drillrig_env
from drillrig_env.moved import keep_former_names

FORMER = {
    "drillrig_env.batch": "drillrig_env.stepper.batch",
    "drillrig_env.stick_slip": "drillrig_env.verdict",
    "drillrig_env.measured": "drillrig_env.calibrate.measured",
}


@pytest.mark.parametrize(("former", "name"), FORMER.items())
def test_former_name_is_the_module_and_warns(former, name):
    sys.modules.pop(former, None)
    with pytest.warns(DeprecationWarning, match=f"{former} is now {name}"):
        module = importlib.import_module(former)
    assert module is importlib.import_module(name)
    assert module.__spec__.name == name


def test_names_are_imported_from_a_former_module():
    sys.modules.pop("drillrig_env.batch", None)
    with pytest.warns(DeprecationWarning, match="drillrig_env.stepper.batch"):
        from drillrig_env.batch import simulate_batch
    assert simulate_batch is drillrig_env.simulate_batch


def test_pickle_that_names_a_former_module_loads():
    sys.modules.pop("drillrig_env.stick_slip", None)
    with pytest.warns(DeprecationWarning, match="drillrig_env.verdict"):
        loaded = pickle.loads(b"cdrillrig_env.stick_slip\nstick_slip_index\n.")
    from drillrig_env.verdict import stick_slip_index

    assert loaded is stick_slip_index


def test_former_module_runs_as_a_command():
    command = [sys.executable, "-W", "always", "-m", "drillrig_env.measured", "--help"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "usage" in done.stdout.lower()
    assert "drillrig_env.measured is now drillrig_env.calibrate.measured" in done.stderr


def test_unknown_module_is_left_to_others():
    keep_former_names({})
    sys.meta_path.pop()
    with pytest.raises(ModuleNotFoundError, match=r"drillrig_env\.nonsense"):
        importlib.import_module("drillrig_env.nonsense")
