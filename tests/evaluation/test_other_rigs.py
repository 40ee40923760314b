"""Suites, scores and pictures on rigs of other sizes: the same cases, scaled."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from drillrig_env import Rig, Task
from drillrig_env.evaluation.conditions import Conditions
from drillrig_env.evaluation.contest import config_of, run_contest
from drillrig_env.evaluation.contestants import find_contestants
from drillrig_env.evaluation.histories import Histories
from drillrig_env.evaluation.pictures import plot_calming, plot_histories, plot_scores
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import SUITES, suite
from drillrig_env.policy import context_of, make_policy
from drillrig_env.scales import Scales
from drillrig_env.verdict import is_calm
from tests.rigs import FIELD, scaled

TIME, TORQUE = 4.0, 0.5
SLOW = scaled(TIME, TORQUE)


@pytest.mark.parametrize("name", SUITES)
def test_a_suite_of_a_scaled_rig_has_the_same_scores(name):
    scores = []
    for rig in (Rig(), SLOW):
        one = suite(name, 8, Scales.of(rig))
        context = {**context_of(Task.for_rig(rig)), "slew_limit": one.slew_limit}
        scores.append(score(run(make_policy("z_torque", **context), one, rig=rig)))
    own, slow = scores
    factors = {"speed_target": TIME, "critical_speed": TIME, "fold": TIME, "travel": TIME, "time_to_calm": 1 / TIME}
    factors |= {"v_b": 1 / TIME}
    for column, values in own.items():
        found = slow[column]
        if values.dtype.kind in "US":
            np.testing.assert_array_equal(found, values)
        else:
            np.testing.assert_allclose(found * factors.get(column, 1.0), values, rtol=1e-6, err_msg=column)


def test_standing_is_told_from_calm_by_the_rigs_own_speeds():
    assert is_calm(0.99e-3, 1.01e-3, 1e-3, speed_scale=1e-3)
    assert not is_calm(0.99e-3, 1.01e-3, 1e-3)
    assert not is_calm(4.9, 5.1, 5.0, speed_scale=100.1)


@pytest.mark.slow
def test_a_contest_on_another_rig_says_so_and_draws_its_times():
    contestants, failures, conditions = find_contestants(["constant", "lqg"], rig=FIELD, largest_reference=50.0)
    assert not failures
    assert conditions.scales == Scales.of(FIELD, 50.0)
    chosen = [suite("default", 12, conditions.scales)]
    results = Results(config_of(conditions, chosen, contestants, "0", "", "constant"))
    histories = Histories()
    assert not run_contest(chosen[0], contestants, results, histories)
    assert (results.config["largest_reference"], results.scales) == (50.0, conditions.scales)
    duration = Task.for_rig(FIELD).duration
    assert results.scores["default"]["constant"]["time_to_calm"].max() == pytest.approx(duration, rel=1e-5)
    calming, scores = plot_calming(results, "default"), plot_scores(results, "default")
    assert "trailing 9.73 s" in calming.caption
    assert "last 19.5 s" in scores.caption
    assert "317: never" in scores.figure.axes[2].get_xlabel()
    history = plot_histories(results, histories, "default", "bistable")
    assert history.figure.axes[0].get_xlim()[1] == pytest.approx(duration)
    plt.close("all")


def test_conditions_without_a_speed_are_the_rigs_own():
    assert Conditions("DrillRig-v0", 0.0, (0, 0)).scales == Scales()
    assert "largest_reference" not in Conditions("DrillRig-v0", 0.0, (0, 0), FIELD).arguments
