"""Everyone is put through the suites; failures stay their own; what is there already is not run again."""

import numpy as np
import pytest

from drillrig_env import Drive, Rig
from drillrig_env.evaluation.conditions import Conditions
from drillrig_env.evaluation.contest import Contestant, config_of, run_contest
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.store import read
from drillrig_env.evaluation.suites import suite
from tests.evaluation.conftest import compare, contestants

SUITE, OTHER = suite("default", 6), suite("degraded", 6)


class Hold:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 1), np.float32), None


class Raises(Hold):
    privileged = ("normal_force",)

    def tell(self, info):
        raise RuntimeError("no telling")


class Flat(Hold):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros(len(observation), np.float32), None


class NotANumber(Hold):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.full((len(observation), 1), np.nan, np.float32), None


class Leaves(Hold):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        raise SystemExit(0)


class Closes(Hold):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        raise GeneratorExit


class Interrupts(Hold):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        raise KeyboardInterrupt


class CannotBeMade(Hold):
    def __init__(self):
        raise KeyError("gain")


def contestant(policy, name=None):
    return Contestant(name or policy.__name__, {"": lambda suite: policy()}, {"sensors": "state"})


def test_a_policy_that_fails_is_named_and_the_others_go_on(tmp_path):
    field = [contestant(policy) for policy in (Raises, Flat, NotANumber, Leaves, CannotBeMade, Closes, Hold)]
    results = Results({"policies": {}})
    failures = run_contest(SUITE, field, results, Histories(), tmp_path)
    assert [failure.policy for failure in failures] == [one.name for one in field[:-1]]
    assert "no telling" in str(failures[0])
    assert failures[0].trace.count("File ") == 3  # the innermost calls
    assert failures[0].trace.endswith('raise RuntimeError("no telling")')
    assert "shape (6,)" in str(failures[1])
    assert "NotANumber: the action for rig 0 (seed 1000000000) in control step 1 is not finite" in str(failures[2])
    assert "SystemExit" in str(failures[3])
    assert "gain" in str(failures[4])
    assert "GeneratorExit" in str(failures[5])
    assert read(tmp_path).policies == results.policies == ["Hold"]


def test_ctrl_c_ends_the_contest_and_is_no_failure():
    results = Results({"policies": {}})
    with pytest.raises(KeyboardInterrupt):
        run_contest(SUITE, [contestant(policy) for policy in (Hold, Interrupts)], results, Histories())
    assert results.policies == ["Hold"]


def test_a_contestant_without_members_fails_in_a_sentence():
    (failure,) = run_contest(SUITE, [Contestant("nobody", {}, {"sensors": "state"})], Results(), Histories())
    assert str(failure) == "nobody failed in default: ValueError: nobody has no members; allowed: at least one"


def test_config_names_a_rig_only_where_it_is_not_the_standard_one_and_a_drive_where_it_is_set():
    field = [contestant(Hold), Contestant("soft", {"": Hold}, {"sensors": "state"}, drive=Drive(0.3, 0.5))]

    def config(rig):
        return config_of(Conditions("DrillRig-v0", 0.0, (0, 0), rig), [SUITE], field, "1", "command", "Hold")

    assert "rig" not in config(Rig())
    assert Rig(**config(Rig(J_1=0.04))["rig"]) == Rig(J_1=0.04)
    drives = [policy["drive"] for policy in config(Rig())["policies"].values()]
    assert drives[0] is None
    assert drives[1]["k_p"] == 0.3


def test_only_who_says_so_is_privileged():
    class Listens(Hold):
        heard = 0

        def tell(self, info):
            Listens.heard += 1

    run(Listens(), suite("default", 1))
    assert Listens.heard == 0
    Listens.privileged = ("mu_s",)
    run(Listens(), suite("default", 1))
    assert Listens.heard == 600


def test_the_drives_gains_are_the_policys():
    class Soft(Hold):
        drive = Drive(0.3, 0.5)

    assert not np.array_equal(run(Soft(), SUITE).average, run(Hold(), SUITE).average)


@pytest.mark.slow
def test_twice_the_same_comparison_is_the_same_file(comparison):
    results, _ = comparison
    again, _ = compare([suite(name, 24) for name in ("default",)])
    rows = [row for row in results.rows.splitlines() if row.startswith(("suite", "default"))]
    assert again.rows.splitlines() == rows


def test_what_is_there_is_not_run_again_and_the_order_stays(tmp_path):
    whole, _ = compare([SUITE, OTHER], folder=tmp_path / "whole")
    part = Results(whole.config, whole.provenance)
    field, kept = contestants(), Histories()
    run_contest(SUITE, field[1:2], part, kept, tmp_path / "part")
    resumed = read(tmp_path / "part")
    ran = []
    for one in (SUITE, OTHER):
        run_contest(
            one, field, resumed, kept, tmp_path / "part", lambda name, done, of, one=one: ran.append((one.name, name))
        )
    assert ("default", "privileged") not in ran
    assert ("degraded", "privileged") in ran
    assert (tmp_path / "part" / "results.csv").read_bytes() == (tmp_path / "whole" / "results.csv").read_bytes()
