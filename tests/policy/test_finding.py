"""Policies by name: installed, from a file, from a run's folder, or as an object; made for what they name."""

from importlib.metadata import EntryPoint, EntryPoints

import pytest

import baselines
from drillrig_env import Rig
from drillrig_env.policy import PolicySource, UnknownPolicyError, find_policy, finding, make_policy, policy_names

FILE = """
import numpy as np
from beside import GAIN


class Law:
    def __init__(self, rig=None, slew_limit=1.0):
        self.rig, self.slew_limit = rig, slew_limit

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return GAIN * np.zeros((len(observation), 1), np.float32), None
"""


@pytest.fixture
def file(tmp_path):
    (tmp_path / "beside.py").write_text("GAIN = 2.0\n")
    (tmp_path / "json.py").write_text(FILE)  # a name that another module has as well
    return tmp_path / "json.py"


def test_baselines_and_trained_agents_have_names():
    assert set(baselines.BASELINES) <= set(policy_names())
    assert {"ppo", "sac_soft", "ppo_surface_soft"} <= set(policy_names())


@pytest.mark.parametrize("name", baselines.BASELINES)
def test_every_baseline_is_found_by_its_name(name):
    source = find_policy(name)
    assert source.makers[""] is baselines.BASELINES[name]
    assert source.slow == baselines.BASELINES[name].slow
    assert source.about == {"kind": "baseline"}


def test_a_policy_is_made_for_the_sensors_rig_and_slew_limit():
    rig = Rig(k_p=2.5)
    made = make_policy("z_torque", sensors="surface", rig=rig, slew_limit=1.5)
    assert (made.sensors.name, made.rig, made.slew_limit) == ("surface", rig, 1.5)
    agent = make_policy("ppo", sensors="state", rig=rig, slew_limit=1.0)
    assert agent.env_kwargs["slew_limit"] == 1.0


def test_a_class_in_a_file_gets_what_it_names(file):
    made = make_policy(f"{file}:Law", sensors="state", rig=3, slew_limit=0.5)
    assert (made.rig, made.slew_limit) == (3, 0.5)
    assert make_policy(f"{file}:Law").slew_limit == 1.0
    import json

    assert json.dumps(1) == "1"
    assert len(find_policy(f"{file}:Law").about["sha256"]) == 64


def test_objects_classes_and_functions_are_policies_too(file):
    law = type(make_policy(f"{file}:Law"))
    one = law()
    assert make_policy(one) is one
    assert isinstance(make_policy(law, slew_limit=3.0), law)
    assert make_policy(lambda slew_limit: law(None, slew_limit), slew_limit=4.0).slew_limit == 4.0


@pytest.mark.parametrize(
    ("name", "hint"), [("lqgg", "did you mean lqg"), ("runs/nothing", "no training run's folder"), (5, "no predict")]
)
def test_what_is_nothing_is_refused_with_the_closest(name, hint):
    with pytest.raises((ValueError, TypeError), match=hint):
        make_policy(name)


def test_a_class_that_a_file_lacks_is_named(file):
    with pytest.raises(ValueError, match="no class 'Lew'; did you mean Law"):
        find_policy(f"{file}:Lew")
    with pytest.raises(UnknownPolicyError, match="there is no file"):
        find_policy(f"{file.parent / 'absent.py'}:Law")


class Package:
    def __init__(self, name):
        self.name = name


def test_a_name_of_the_projects_own_stays_its_own(monkeypatch):
    own = EntryPoint("constant", "baselines:Constant", finding.GROUP)._for(Package("drillrig"))
    other = EntryPoint("constant", "baselines:ZTorque", finding.GROUP)._for(Package("theirs"))
    for entries in ([own, other], [other, own]):
        monkeypatch.setattr(finding, "entry_points", lambda group, found=entries: EntryPoints(found))
        finding._installed.cache_clear()
        assert type(make_policy("constant")) is baselines.Constant
    monkeypatch.undo()
    finding._installed.cache_clear()


def test_other_packages_offer_policies_as_entry_points(monkeypatch):
    entry = EntryPoint("theirs", "baselines:Constant", finding.GROUP)
    monkeypatch.setattr(finding, "entry_points", lambda group: EntryPoints([entry]))
    finding._installed.cache_clear()
    try:
        assert "theirs" in policy_names()
        assert isinstance(make_policy("theirs"), baselines.Constant)
    finally:
        finding._installed.cache_clear()


def test_agents_are_absent_where_the_clone_is(monkeypatch, tmp_path):
    monkeypatch.setattr(finding, "_AGENTS", tmp_path / "finding.py")
    assert "ppo" not in policy_names()
    with pytest.raises(ValueError, match=r"policy 'ppo' is not known.*from its clone .*: pip install -e"):
        find_policy("ppo")


def test_a_source_of_several_seeds_makes_each():
    source = PolicySource("two", {"1": baselines.Constant, "2": baselines.LQG})
    assert isinstance(source.make(), baselines.Constant)
    assert isinstance(source.make("2"), baselines.LQG)
