"""The package's public names: all there, each loaded when it is first used, and no compiler for what needs none."""

import subprocess
import sys

import pytest

import drillrig_env

LIGHT = """
import sys
import drillrig_env
before = set(sys.modules)
import gymnasium
assert {"DrillRig-v0", "DrillRigSurface-v0"} <= set(gymnasium.registry)
assert not {"scipy", "numba"} & before, "loaded by the import"
rig, friction = drillrig_env.Rig(), drillrig_env.Friction(20.0)
drillrig_env.ENVIRONMENTS, drillrig_env.STARTS, drillrig_env.Scenario()
drillrig_env.Drive(1.0, 1.0), drillrig_env.Reward()
drillrig_env.observation_table("surface"), rig.describe(), friction.as_array()
import drillrig_env.parameters, drillrig_env.verdict, drillrig_env.model
print("numba" in sys.modules)
"""


def test_what_needs_no_kernel_loads_no_compiler():
    done = subprocess.run([sys.executable, "-c", LIGHT], capture_output=True, text=True)
    assert (done.stdout, done.returncode) == ("False\n", 0), done.stderr


@pytest.mark.parametrize("name", drillrig_env.__all__)
def test_public_name_is_there_and_listed(name):
    assert getattr(drillrig_env, name) is not None
    assert name in dir(drillrig_env)


def test_lazy_names_are_public_and_come_from_where_they_are_written():
    assert set(drillrig_env._PLACES) <= set(drillrig_env.__all__)
    assert drillrig_env.simulate.__module__ == "drillrig_env.simulation"
    assert drillrig_env.stability.__name__ == "drillrig_env.stability"


def test_unknown_name_is_no_attribute():
    with pytest.raises(AttributeError, match="module 'drillrig_env' has no attribute 'nonsense'"):
        _ = drillrig_env.nonsense
