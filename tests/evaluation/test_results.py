"""Results come back from their rows as they were written, and so do all tables."""

import csv
import inspect
import io
import json
from pathlib import Path

import numpy as np
import pytest

from drillrig_env.evaluation.report import rows
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.store import read
from drillrig_env.evaluation.tables import OTHERS, all_estimates, estimates, stored_row


def as_json(value):
    return json.loads(json.dumps(value).replace("NaN", "null"))


def as_written(results):
    return Results.of_rows(results.rows, results.config, results.provenance, results.estimates)


def test_tables_from_the_rows_are_those_of_the_run(comparison):
    results, _ = comparison
    again = as_written(results)
    assert again.rows == results.rows
    assert again.privileged == {"constant": False, "privileged": True, "seeds": True}
    assert as_json(all_estimates(again.scores, "constant")) == as_json(again.estimates) == as_json(results.estimates)


def test_every_episode_is_a_row(comparison):
    results, _ = comparison
    found = list(csv.DictReader(io.StringIO(results.rows)))
    assert len(found) == 3 * (24 + 24 + 3 * 24)
    assert [row["seed"] for row in found if row["policy"] == "seeds"][:72:24] == ["0", "1", "2"]
    mitigated = [int(row["mitigated"]) for row in found if (row["suite"], row["policy"]) == ("default", "constant")]
    assert mitigated == results.scores["default"]["constant"]["mitigated"].astype(int).tolist()


def test_no_rows_are_no_results():
    assert Results.of_rows("", {}, {}, {}).scores == {}


def test_other_columns_than_those_before_are_refused(comparison):
    results = as_written(comparison[0])
    scores = dict(results.scores["default"]["constant"])
    scores.pop("cost")
    with pytest.raises(ValueError, match="the scores of late in default have other columns"):
        results.add("default", "late", scores)


def test_stored_estimates_read_as_they_were(comparison):
    results, _ = comparison
    for policy, row in rows(results.scores["default"]).items():
        assert str(stored_row(as_json(results.estimates)["default"][policy]["main"])) == str(row)


def test_suites_are_put_into_their_own_order_and_policies_into_the_one_that_is_given():
    results, scores = Results(), {"seed": np.array(["", ""]), "episode": np.arange(2), "cost": np.ones(2)}
    for suite in ("mine", "wide", "default"):
        for policy in ("b", "c", "a"):
            results.add(suite, policy, scores)
    results.arrange(["a", "b"])
    assert list(results.scores) == ["default", "wide", "mine"]
    assert [list(policies) for policies in results.scores.values()] == [["a", "b", "c"]] * 3
    assert results.policies == ["a", "b", "c"]


@pytest.mark.parametrize("policy", ["constant", "lqg"])
def test_published_intervals_come_out_again_from_the_published_scores(policy):
    published = read(Path(__file__).parents[2] / "docs" / "results" / "DrillRigSurface-v0")
    found = estimates(published.scores["default"][policy], OTHERS.columns)
    for heading, estimate in stored_row(published.estimates["default"][policy]["others"]).items():
        assert vars(found[heading]) == pytest.approx(vars(estimate), rel=1e-9)


def test_results_are_made_of_what_was_asked_for_and_found():
    """Rows and header are made from the scores; nobody gives them."""
    assert list(inspect.signature(Results).parameters) == ["config", "provenance", "scores", "estimates"]
