"""Values, ramps and plans of what the operator gives."""

import numpy as np
import pytest

from drillrig_env.course import COLUMNS
from drillrig_env.env.task import Task
from drillrig_env.room.given import Given

VALUES = {"normal_force": 10.0, "mu_s": 0.5, "mu_k": 0.3, "v_b": 1.0, "speed_target": 2.5}


@pytest.fixture
def given():
    return Given(Task(), dict(reversed(VALUES.items())))


def test_values_hold_from_the_coming_step_on(given):
    np.testing.assert_array_equal(given.row(0), [VALUES[name] for name in COLUMNS])
    given.set({"normal_force": 12, "mu_k": 0.2})
    np.testing.assert_array_equal(given.row(1), [12.0, 0.5, 0.2, 1.0, 2.5])
    assert given.friction().as_dict() == {
        "normal_force": 12,
        "mu_s": 0.5,
        "mu_k": 0.2,
        "v_b": 1.0,
        "law": "exponential",
    }


def test_a_ramp_goes_straight_and_ends_where_it_leads(given):
    given.ramp("normal_force", 20.0, 1.0, step=5)
    assert given.ramps == {"normal_force": 20.0}
    forces = [given.row(step)[0] for step in range(5, 17)]
    np.testing.assert_allclose(forces, [11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 20, 20])
    assert given.ramps == {}
    assert given.values["normal_force"] == 20.0


def test_a_value_set_by_hand_ends_its_ramp_alone(given):
    given.ramp("normal_force", 20.0, 1.0, step=0)
    given.ramp("speed_target", 3.5, 1.0, step=0)
    given.set({"normal_force": 7.0})
    row = given.row(0)
    assert (row[0], row[4]) == (7.0, 2.6)


def test_a_plan_comes_by_itself():
    given = Given(Task(), VALUES, {3: {"normal_force": 15.0}})
    assert [given.row(step)[0] for step in range(5)] == [10, 10, 10, 15, 15]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"normal_force": -1.0}, "normal_force = -1.0 N is not allowed; allowed: >= 0 and <= 10000 N"),
        ({"normal_force": float("nan")}, "normal_force = nan N"),
        ({"normal_force": ""}, "normal_force = '' is not a number"),
        ({"speed_target": 0.0}, "speed_target = 0.0 rad/s is not allowed; allowed: >= 0.01 and <= 10 rad/s"),
        ({"speed_target": "fast"}, "speed_target = 'fast' is not a number"),
        ({"mu_k": 0.6}, "mu_s = 0.5 is not allowed; allowed: >= mu_k = 0.6"),
        ({"v_b": -2}, "v_b = -2 s/rad is not allowed; allowed: > 0 and <= 10000 s/rad"),
        ({"normal_force": 1e300}, "normal_force = 1e+300 N is not allowed; allowed: >= 0 and <= 10000 N"),
        ({"mu_s": 1e12}, "mu_s = 1000000000000.0 is not allowed; allowed: >= 0 and <= 100"),
        ({"weight": 3.0}, "unknown value 'weight'"),
    ],
)
def test_what_is_not_allowed_changes_nothing(given, changes, sentence):
    with pytest.raises(ValueError, match="allowed") as refused:
        given.set(changes)
    assert sentence in str(refused.value)
    np.testing.assert_array_equal(given.row(0), [VALUES[name] for name in COLUMNS])


def test_a_plan_is_checked_like_what_is_given_by_hand():
    with pytest.raises(ValueError, match="mu_k = 101 is not allowed"):
        Given(Task(), VALUES, {3: {"mu_k": 101}})


def test_what_is_allowed_grows_with_the_rig():
    task = Task.for_rig("field_2500m")
    values = {**VALUES, "speed_target": 1.3}
    scales = task.scales
    Given(task, {**values, "normal_force": 0.9e4 * scales.force, "v_b": 0.9e4 / scales.speed})
    with pytest.raises(ValueError, match="normal_force"):
        Given(task, {**values, "normal_force": 1.1e4 * scales.force})


@pytest.mark.parametrize(
    ("ramp", "sentence"),
    [
        (("normal_force", 1e300, 1.0), "normal_force = 1e+300 N is not allowed; allowed: >= 0 and <= 10000 N"),
        (("normal_force", -5.0, 1.0), "normal_force = -5.0 N"),
        (("normal_force", 5.0, 0.0), "time of a ramp = 0.0 s"),
        (("normal_force", 5.0, 601), "time of a ramp = 601 s"),
        (("normal_force", 5.0, "soon"), "time of a ramp = 'soon' is not a number"),
        (("weight", 5.0, 1.0), "unknown value"),
    ],
)
def test_a_ramp_that_cannot_be_is_refused(given, ramp, sentence):
    with pytest.raises(ValueError, match=r"control room|Friction") as refused:
        given.ramp(*ramp, step=0)
    assert sentence in str(refused.value)
    assert given.ramps == {}
