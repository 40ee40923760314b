import json
import re
from pathlib import Path

import numpy as np
import pytest

from agents.compared import SUITES
from agents.pictures import draw_all
from agents.pictures.one_rig import typical_rig
from agents.pictures.phase_plane import observation, rates_on_plane
from agents.policy.run_folder import TRAINED, read_seeds
from agents.rivals import ahead
from baselines import Constant
from docs.make.agents import AGENT, COMMAND, page
from drillrig_env.env.sensors import Sensors
from drillrig_env.evaluation.suites import suite
from tests.evaluation.conftest import compare

DOCS = Path(__file__).parents[2] / "docs"


def run_of(share):
    scores = {"mitigated": share, "calm": 1.0, "below": None, "time_to_calm": 9.0, "cost": 0.2}
    return {"seconds": 90.0, "machine": "one", "scores": dict.fromkeys(SUITES, scores)}


@pytest.fixture
def docs(tmp_path):
    one = {"words": "the shipped setting", "rigs": 10, "env_id": "DrillRig-v0"}
    one |= {
        "hyperparameters": {"n_timesteps": 1000, "critic_iterations": 10, "n_steps": 12, "n_envs": 8},
        "runs": {"0": run_of(0.25), "1": run_of(0.75)},
    }
    made = {"command": "the command", "provenance": {"date": "today", "machine": "one"}, "settings": {"recipe": one}}
    made["beside"] = {"rigs": 10, "policies": {"constant": {**run_of(0.125), "words": "action 0, same drive"}}}
    (tmp_path / "agents").mkdir()
    for name in ("ablations", "newcomer"):
        (tmp_path / "agents" / f"{name}.json").write_text(json.dumps(made))
    (tmp_path / "agents" / "findings.md").write_text("Words of a person.\n")
    return tmp_path


@pytest.mark.slow
def test_page_has_scores_learning_words_choices_and_use(docs, trained):
    text = page(docs, trained)
    for words in (
        "[`ppo`](../agents/trained/ppo/README.md)",
        "so that the spread over seeds is likely too narrow",
        "steps to 0.9",
        "Words of a person.",
        "| the shipped setting | 1,000, 960 of them the critic's alone | 2 | 0.500 (0.250 to 0.750) | none | 0.500 (",
        "| action 0, same drive | | | 0.125 | none | 0.125 | 0.125 | 9.0 | 0.200 | |",
        "| action 0, the rig's own drive, `DrillRig-v0` |",
        "| the shipped setting | 1,000, 960 of them the critic's alone | 2 | 0.500 (0.250 to 0.750) | 1.000",
        "python -m agents.export",
        "ablations: `the command`, today, one (2 trainings)",
    ):
        assert words in text
    assert "Where the physics" not in text
    assert not re.search(r"\bnan\b", text)


def test_page_is_without_comparisons_that_were_not_made(docs, trained):
    (docs / "agents" / "newcomer.json").unlink()
    text = page(docs, trained)
    assert "## What each choice is worth" in text
    assert "newcomer" not in text


def test_agent_that_is_shown_must_be_there(docs, tmp_path):
    with pytest.raises(ValueError, match="no agent 'ppo'"):
        page(docs, tmp_path)


@pytest.mark.slow
def test_pictures_of_the_page_are_drawn(docs, trained):
    shown = set(re.findall(r"\]\(images/agents/(.+)\)", page(docs, trained)))
    paths = draw_all(AGENT, docs, trained)
    assert {path.name for path in paths} == shown
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)


def test_rivals_that_are_ahead_are_named():
    results, _ = compare([suite("default", 24)])
    stored = {"DrillRig-v0": results}
    found = dict(re.findall(r"\| `default` \| (\S+) \| (.*) \|", ahead(stored, {"constant": "DrillRig-v0"})))
    tables = {policy: one["main"] for policy, one in results.estimates["default"].items()}
    share, rival, theirs, clear = found["mitigated"].split(" | ")
    assert float(share) == pytest.approx(tables["constant"]["mitigated"]["value"], abs=6e-4)
    assert rival in ("`privileged`*", "`seeds`")
    assert float(share) < float(theirs) == pytest.approx(tables[rival.strip("`*")]["mitigated"]["value"], abs=6e-4)
    assert clear == (
        "yes" if tables["constant"]["mitigated"]["high"] < tables[rival.strip("`*")]["mitigated"]["low"] else "no"
    )
    assert "cost" not in found  # racing past the fold costs more than it gains
    assert ahead(stored, {"absent": "DrillRig-v0"}) == ""
    assert ahead({}, {"constant": "DrillRig-v0"}) == ""


def test_plane_is_what_the_policy_answers():
    """Holding the target asks for no change anywhere; observations are made as the environment makes them."""
    typical = typical_rig()
    assert typical.speed_target < typical.critical_speed
    twists, speeds, rates, twist = rates_on_plane(Constant(), {"sensors": "state"}, typical, {})
    assert rates.shape == (len(speeds), len(twists))
    np.testing.assert_allclose(rates, 0.0, atol=1e-5)
    assert twists[0] < twist < twists[-1] < 0.5
    sensors = Sensors.named("state")
    shown = np.random.default_rng(0).uniform(-1.0, 1.0, (5, len(sensors.names))).astype(np.float32)
    np.testing.assert_allclose(observation(sensors, sensors.values(shown)), shown, atol=1e-6)


@pytest.mark.skipif(read_seeds(TRAINED / AGENT) is None, reason="no agent is shipped")
def test_the_projects_page_is_up_to_date():
    assert (DOCS / "agents.md").read_text(encoding="utf-8") == page(DOCS), f"out of date; run: {COMMAND}"
