"""Who competes, and how: seen through the environment's sensors, or through those that the policy names."""

import pytest

from drillrig_env import Rig
from drillrig_env.evaluation.conditions import Conditions
from drillrig_env.evaluation.contest import run_contest
from drillrig_env.evaluation.contestants import contestant_of, find_contestants
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.suites import suite
from drillrig_env.policy.finding import PolicySource, UnknownPolicyError, find_policy

HOLD = """
import numpy as np


class Hold:
    sensors = {sensors}

    def __init__(self, slew_limit=1.0):
        self.slew_limit, self.name, self.size, self._hidden, self.table = slew_limit, "hold", 3, 4, [5]

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 1), np.float32), None
"""


def file_of(folder, name="laws.py", sensors="None"):
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(HOLD.format(sensors=sensors))
    return f"{path}:Hold"


def test_contestant_says_what_it_is_told_and_what_tells_it_from_others():
    found = contestant_of(find_policy("jump_ease"), "DrillRig-v0")
    assert (found.name, found.privileged) == ("jump_ease", ("normal_force", "mu_s", "mu_k", "v_b"))
    parameters = found.about["parameters"]
    assert {"margin": 0.1, "of_basin": 0.06}.items() <= parameters.items()
    assert "slew_limit" not in parameters
    assert not any(name.startswith("_") for name in parameters)


def test_parameters_are_the_plain_values_of_a_policy(tmp_path):
    found = contestant_of(find_policy(file_of(tmp_path)), "DrillRig-v0", "mine")
    assert found.about["parameters"] == {"name": "hold", "size": 3}
    assert found.name == "mine"
    made = find_policy(file_of(tmp_path))
    trained = contestant_of(PolicySource("x", made.makers, {"kind": "run"}), "DrillRig-v0")
    assert trained.about == {"kind": "run"}  # its parameters are in its folder


def test_who_is_exact_is_shown_more_than_the_sensors_and_says_so():
    found = contestant_of(find_policy("baselines/told.py:LQROfRig"), "DrillRigUnknown-v0")
    assert found.exact
    assert "bit_speed" in found.env["sensors"]
    assert found.description()["exact"] is True
    fair = contestant_of(find_policy("lqg"), "DrillRigUnknown-v0").description()
    assert "exact" not in fair
    marks = Results({"policies": {"LQROfRig": found.description(), "lqg": fair}}).marks
    assert marks == {"LQROfRig": "*", "lqg": ""}
    told = contestant_of(find_policy("baselines/told.py:JumpEaseOfBit"), "DrillRigUnknown-v0").description()
    assert told["privileged"] == []
    assert Results({"policies": {"x": told}}).privileged == {"x": True}


def test_members_are_made_for_the_fleet_of_the_suite():
    found = contestant_of(find_policy("baselines/told.py:LQGOfRig"), "DrillRigUnknown-v0")
    faced = suite("unknown", 3)
    (member,) = (make(faced) for make in found.members.values())
    assert member.plants == faced.scenario.rigs.members().rigs
    (member,) = (make(suite("default", 3)) for make in found.members.values())
    assert member.plants == (Rig(),)


def test_members_are_made_for_the_slew_limit_of_the_suite(tmp_path):
    found = contestant_of(find_policy(file_of(tmp_path)), "DrillRig-v0")
    for name in ("default", "degraded"):
        (member,) = (make(suite(name, 4)) for make in found.members.values())
        assert member.slew_limit == suite(name, 4).slew_limit


def test_who_names_sensors_sees_these_as_good_as_those_of_the_environment(tmp_path):
    own = contestant_of(find_policy(file_of(tmp_path, sensors='("top_speed", "speed_target")')), "DrillRigSurface-v0")
    assert own.env["sensors"] == ("top_speed", "speed_target")
    assert (own.env["noise"], own.env["delay"]) == (1.0, (1, 1))
    whatever = contestant_of(find_policy(file_of(tmp_path, "others.py")), "DrillRigSurface-v0")
    assert whatever.env == {"sensors": "surface", "noise": 1.0, "delay": (1, 1)}
    noisy = contestant_of(find_policy(file_of(tmp_path)), Conditions("DrillRig-v0", 2.0, (1, 3)))
    assert noisy.env == {"sensors": "state", "noise": 2.0, "delay": (1, 3)}


def test_who_must_see_what_is_not_shown_cannot_compete(tmp_path):
    name = file_of(tmp_path, sensors='("bit_speed", "speed_target")')
    with pytest.raises(ValueError, match=r"sees bit_speed, which the sensors of DrillRigSurface-v0 do not show"):
        contestant_of(find_policy(name), "DrillRigSurface-v0", "mine")
    contestants, failures, _ = find_contestants([name, "constant"], "DrillRigSurface-v0")
    assert [one.name for one in contestants] == ["constant"]
    (failure,) = failures
    assert failure.trace == ""
    assert " sees bit_speed, which the sensors of DrillRigSurface-v0 do not show" in failure.error
    assert failure.error.endswith("; those of DrillRig-v0 do")


def test_a_name_that_is_nothing_is_refused_before_any_other_is_made():
    with pytest.raises(UnknownPolicyError, match=r"policy 'constnat' is not known.*did you mean constant"):
        find_contestants(["lqg", "constnat"], "DrillRig-v0")


def test_a_file_that_cannot_be_read_is_a_failure_and_the_others_compete(tmp_path):
    (tmp_path / "broken.py").write_text("def broken(:")
    contestants, failures, conditions = find_contestants([f"{tmp_path / 'broken.py'}:Hold", "constant"])
    assert [one.name for one in contestants] == ["constant"]
    assert "SyntaxError" in str(failures[0])
    assert conditions == Conditions.of("DrillRig-v0")


NAMED = (("mppi",), False, True)


@pytest.mark.parametrize(("names", "slow", "competes"), [((), False, False), ((), True, True), NAMED])
def test_slow_ones_compete_when_they_are_named_or_let_in(names, slow, competes, monkeypatch):
    monkeypatch.setattr("drillrig_env.evaluation.contestants.policy_names", lambda: ["constant", "mppi"])
    said = []
    contestants, failures, _ = find_contestants(names, "DrillRig-v0", slow, said.append)
    assert ("mppi" in [one.name for one in contestants]) == competes
    assert bool(said) == (not competes)
    assert failures == []


def test_without_names_who_does_not_suit_is_left_out_with_a_word(monkeypatch):
    names = ["constant", "jump_ease_estimated", "mppi"]
    monkeypatch.setattr("drillrig_env.evaluation.contestants.policy_names", lambda: names)
    said = []
    contestants, failures, _ = find_contestants((), "DrillRigSurface-v0", say=said.append)
    assert [one.name for one in contestants] == ["constant"]
    assert failures == []
    slow, unsuited = said
    assert slow == "mppi is left out: it is slow; --slow lets it in"
    assert unsuited.startswith("jump_ease_estimated is left out: JumpEaseEstimated reads")


@pytest.mark.parametrize("names", [(), ("ppo", "constant")])
def test_who_needs_what_is_not_installed_is_left_out_unless_named(names, monkeypatch):
    def find(name):
        if name == "ppo":
            raise ImportError("a trained agent needs PyTorch")
        return find_policy(name)

    monkeypatch.setattr("drillrig_env.evaluation.contestants.find_policy", find)
    monkeypatch.setattr("drillrig_env.evaluation.contestants.policy_names", lambda: ["constant", "ppo"])
    said = []
    contestants, failures, _ = find_contestants(names, "DrillRig-v0", say=said.append)
    assert [one.name for one in contestants] == ["constant"]
    assert said == ([] if names else ["ppo is left out: a trained agent needs PyTorch"])
    assert len(failures) == bool(names)


def test_names_in_tables_are_short_unless_two_end_alike(tmp_path):
    here, there = file_of(tmp_path / "here"), file_of(tmp_path / "there")
    assert [one.name for one in find_contestants([here, "constant"], "DrillRig-v0")[0]] == ["Hold", "constant"]
    assert [one.name for one in find_contestants([here, there], "DrillRig-v0")[0]] == [here, there]


def test_contest_tells_its_progress_over_all_seeds(tmp_path):
    make = next(iter(find_policy(file_of(tmp_path)).makers.values()))
    contestant = contestant_of(PolicySource("twice", {"0": make, "1": make}), "DrillRig-v0")
    assert list(contestant.members) == ["0", "1"]
    told = []
    run_contest(suite("default", 2), [contestant], Results(), Histories(), progress=lambda *news: told.append(news))
    assert told == [("twice", step, 1200) for step in range(1, 1201)]


@pytest.mark.parametrize("place", ["while the file is read", "while the policy is made"])
def test_ctrl_c_ends_the_search_at_once(tmp_path, place):
    text = HOLD.format(sensors="None")
    interrupt = "raise KeyboardInterrupt"
    path = tmp_path / "laws.py"
    path.write_text(
        interrupt if "file" in place else text.replace("self.slew_limit,", f"{interrupt}\n        self.slew_limit,")
    )
    with pytest.raises(KeyboardInterrupt):
        find_contestants([f"{path}:Hold", "constant"], "DrillRig-v0")


def test_policies_are_made_for_the_rig_of_the_suites(tmp_path):
    path = tmp_path / "laws.py"
    path.write_text(
        HOLD.format(sensors="None").replace("slew_limit=1.0", "rig=None, slew_limit=1.0").replace("[5]", "rig")
    )
    ((found,), _, conditions) = find_contestants([f"{path}:Hold"], "DrillRig-v0", rig={"J_1": 0.04})
    (member,) = (make(suite("default", 4)) for make in found.members.values())
    assert member.table == conditions.rig == found.env["rig"] == Rig(J_1=0.04)
