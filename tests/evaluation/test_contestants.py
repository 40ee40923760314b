"""Who competes: everyone who can, each by a name of its own, and under the same conditions."""

import pytest

from drillrig_env.evaluation.conditions import Conditions
from drillrig_env.evaluation.contestants import contestant_of, find_contestants
from drillrig_env.policy import UnknownPolicyError, find_policy

FILE = """
import numpy as np


class Hold:
    def __init__(self, gain=2.0, slew_limit=1.0):
        self.gain, self.slew_limit, self._hidden = gain, slew_limit, 3

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 1), np.float32), None


class Sees(Hold):
    sensors = ("twist_12",)


class Broken(Hold):
    def __init__(self):
        raise KeyError("gain")
"""


@pytest.fixture
def file(tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.py").write_text(FILE)
    return tmp_path / "a" / "mine.py"


def test_a_name_that_is_nothing_is_refused_before_any_other_is_made():
    with pytest.raises(UnknownPolicyError, match=r"policy 'constnat' is not known.*did you mean constant"):
        find_contestants(["lqg", "constnat"], "DrillRig-v0")


def test_one_that_cannot_be_made_is_a_failure_and_the_others_compete(file):
    found, failures, conditions = find_contestants([f"{file}:Broken", "constant", f"{file}:Hold"])
    assert [one.name for one in found] == ["constant", "Hold"]
    assert [str(one) for one in failures] == ["Broken failed: KeyError: 'gain'"]
    assert conditions == Conditions.of("DrillRig-v0")


def test_a_file_that_cannot_be_read_is_a_failure(file):
    file.write_text("def broken(:")
    found, failures, _ = find_contestants([f"{file}:Hold", "constant"])
    assert [one.name for one in found] == ["constant"]
    assert "SyntaxError" in str(failures[0])


def test_names_that_end_alike_are_given_in_full(file):
    names = [f"{file}:Hold", f"{file.parents[1] / 'b' / 'mine.py'}:Hold"]
    found, failures, _ = find_contestants(names)
    assert not failures
    assert [one.name for one in found] == names


def test_a_policy_is_shown_what_it_sees_at_the_contests_noise_and_delay(file):
    held = Conditions("DrillRig-v0", 2.0, (1, 3))
    sees = contestant_of(find_policy(f"{file}:Sees"), held)
    assert sees.env == {"sensors": ("twist_12",), "noise": 2.0, "delay": (1, 3)}
    with pytest.raises(ValueError, match="Sees sees twist_12, which the sensors of DrillRigSurface-v0 do not show"):
        contestant_of(find_policy(f"{file}:Sees"), "DrillRigSurface-v0", "Sees")


def test_plain_values_tell_a_policy_from_a_changed_one(file):
    about = contestant_of(find_policy(f"{file}:Hold"), "DrillRig-v0").about
    assert about["parameters"] == {"gain": 2.0}
    assert len(about["sha256"]) == 64
