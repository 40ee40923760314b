import csv

import pytest

from agents.policy.run_folder import read_config, read_seeds
from agents.shipping.failures import FILE, failures, write_failures
from drillrig_env.evaluation.contestants import contestant_of
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import default_suite
from drillrig_env.policy import find_policy


def rows_of(text):
    return list(csv.DictReader(text.splitlines()))


def test_failures_are_those_of_one_evaluation_of_as_many_rigs(monkeypatch):
    contestant = contestant_of(find_policy("constant"), "DrillRig-v0")
    monkeypatch.setattr("agents.shipping.failures._AT_ONCE", 16)
    done = []
    text, counts = failures(contestant, 40, lambda at, of: done.append((at, of)))
    suite = default_suite(40)
    scores = score(run(contestant.members[""](suite), suite, **contestant.env))
    rows = rows_of(text)
    assert sorted(int(row["episode"]) for row in rows) == [i for i in range(40) if not scores["mitigated"][i]]
    hardness = [float(row["hardness"]) for row in rows]
    assert hardness == sorted(hardness, reverse=True)
    assert sum(count["rigs"] for count in counts.values()) == 40
    assert sum(count["failed"] for count in counts.values()) == len(rows)
    assert sum(count["calm"] for count in counts.values()) == sum(row["calm"] == "1" for row in rows)
    assert done == [(16, 40), (32, 40), (40, 40)]


def test_card_and_list_tell_the_same_failures(trained):
    counts = read_seeds(trained / "ppo")["failures"]
    listed = rows_of((trained / "ppo" / FILE).read_text(encoding="utf-8"))
    assert sum(count["rigs"] for count in counts.values()) == 120
    assert sum(count["failed"] for count in counts.values()) == len(listed)
    assert {row["seed"] for row in listed} <= {str(read_config(trained / "ppo")["seed"])}
    assert f"does not mitigate {len(listed):,}, of which" in (trained / "ppo" / "README.md").read_text(encoding="utf-8")


def test_an_agent_that_is_not_shipped_is_refused(trained):
    with pytest.raises(ValueError, match=r"sac is not a shipped agent with a seeds\.json"):
        write_failures("sac", 5, trained)
