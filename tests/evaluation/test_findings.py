"""Sentences about results: who wins, whose intervals overlap, and where each policy fails."""

import numpy as np
import pytest

from drillrig_env.evaluation.findings import where_each_fails, who_wins
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.tables import all_estimates

RIGS = 100


def scores(mitigated, calm=None, stuck=0.0):
    """Scores of RIGS rigs, of which the first ones are mitigated; a third of them lies in each region."""
    hits = np.arange(RIGS) < mitigated
    return {
        "seed": np.full(RIGS, ""),
        "episode": np.arange(RIGS),
        "region": np.array([("below", "bistable", "above")[rig % 3] for rig in range(RIGS)]),
        "hardness": np.full(RIGS, 1.5),
        "mitigated": hits,
        "calm": hits if calm is None else np.arange(RIGS) < calm,
        "time_to_calm": np.full(RIGS, 10.0),
        **{name: np.full(RIGS, 1.0) for name in ("cost", "ssi", "peak_speed", "peak_torque", "travel")},
        "stuck": np.full(RIGS, stuck),
    }


@pytest.fixture
def results():
    found = Results({"policies": {"oracle": {"privileged": ["mu_s"]}}}, {})
    for name, one in {
        "best": scores(90),
        "near": scores(88),
        "far": scores(20, calm=60, stuck=0.9),
        "oracle": scores(100),
    }.items():
        found.add("default", name, one)
    found.add("load", "far", scores(5))
    found.estimates = all_estimates(found.scores, "best")
    return found


def test_the_best_that_is_told_nothing_wins_and_who_overlaps_is_named(results):
    first = who_wins(results)[0]
    assert first.startswith("In the suite `default` `best` mitigates 90.0%")
    assert "with an interval that overlaps those of `near` (88.0%)" in first
    assert "`far`" not in first
    assert first.endswith("told more than the sensors show, `oracle` mitigates 100.0%.")
    assert who_wins(results)[-1].startswith("In `load` `far` mitigates 5.0%")


def test_without_anyone_who_is_told_nothing_this_is_said():
    found = Results({"policies": {"oracle": {"privileged": ["mu_s"]}}}, {})
    found.add("default", "oracle", scores(50))
    found.estimates = all_estimates(found.scores, "oracle")
    assert who_wins(found)[0] == "In the suite `default` there is no policy that is told nothing."


def test_each_policy_is_told_its_worst_and_what_becomes_of_its_failures(results):
    sentences = dict(line.split(": ", 1) for line in where_each_fails(results))
    assert "hardness q 1-2 (20.0%)" in sentences["`far`"]
    assert "suite `load` (5.0%)" in sentences["`far`"]
    assert sentences["`far`"].endswith("50% are calm, but not at the target and 50% stand still for most of the time.")
    assert sentences["`best`"].endswith("Of the rigs of `default` that it does not mitigate 100% shake.")
    assert "does not mitigate" not in sentences["`oracle`"]


def test_a_share_of_a_few_rigs_is_nobodys_worst():
    few = {name: values[:15] for name, values in scores(3).items()}
    found = Results({"policies": {}}, {})
    found.add("default", "few", few)
    found.estimates = all_estimates(found.scores, "few")
    assert "region" not in where_each_fails(found)[0]


def test_what_is_worst_is_told_of_the_suite_that_is_asked_for(results):
    sentences = dict(line.split(": ", 1) for line in where_each_fails(results, "load"))
    assert sentences["`far`"].startswith("worst region of `load` ")
    assert "Of the rigs of `load` that it does not mitigate" in sentences["`far`"]
