"""Results come back from their files as they were written, and so do all tables."""

import csv
import json

import numpy as np
import pytest

from drillrig_env.evaluation.histories import read as read_histories
from drillrig_env.evaluation.report import rows
from drillrig_env.evaluation.results import read
from drillrig_env.evaluation.tables import all_estimates, stored_row


def as_json(value):
    return json.loads(json.dumps(value).replace("NaN", "null"))


@pytest.mark.parametrize("compressed", [False, True])
def test_tables_from_the_files_are_those_of_the_run(comparison, tmp_path, compressed):
    results, _ = comparison
    results.save(tmp_path, compressed)
    again = read(tmp_path)
    assert again.rows == results.rows
    assert again.privileged == {"constant": False, "privileged": True, "seeds": True}
    assert as_json(all_estimates(again.scores, "constant")) == as_json(again.estimates) == as_json(results.estimates)


def test_every_episode_is_a_row(comparison, tmp_path):
    results, _ = comparison
    results.save(tmp_path)
    found = list(csv.DictReader((tmp_path / "results.csv").open()))
    assert len(found) == 3 * (24 + 24 + 3 * 24)
    assert [row["seed"] for row in found if row["policy"] == "seeds"][:72:24] == ["0", "1", "2"]
    mitigated = [int(row["mitigated"]) for row in found if (row["suite"], row["policy"]) == ("default", "constant")]
    assert mitigated == results.scores["default"]["constant"]["mitigated"].astype(int).tolist()
    content = json.loads((tmp_path / "results.json").read_text())
    assert content["provenance"]["versions"]["numpy"] == np.__version__
    assert content["config"]["suites"]["degraded"]["env"]["delay"] == [1, 5]
    assert content["config"]["policies"]["privileged"]["privileged"] == ["normal_force", "mu_s", "mu_k", "v_b"]


def test_stored_estimates_read_as_they_were(comparison):
    results, _ = comparison
    for policy, row in rows(results.scores["default"]).items():
        assert str(stored_row(as_json(results.estimates)["default"][policy]["main"])) == str(row)


def test_histories_come_back(comparison, tmp_path):
    _, histories = comparison
    histories.save(tmp_path)
    again = read_histories(tmp_path)
    assert again.kept.keys() == histories.kept.keys()
    for key, history in histories.kept.items():
        for name, values in history.items():
            np.testing.assert_array_equal(again.kept[key][name], values)
    assert read_histories(tmp_path / "none").kept == {}


def test_a_folder_without_results_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"holds no results: results.json is missing"):
        read(tmp_path)
    (tmp_path / "results.json").write_text("{")
    with pytest.raises(ValueError, match="holds no results that can be read"):
        read(tmp_path)
