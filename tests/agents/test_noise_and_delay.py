import json
from dataclasses import replace

import numpy as np
import pytest

from agents import noise_and_delay
from agents.noise_and_delay import NOISES, TOLD, read_shares, section, shares
from agents.pictures import plot_noise_and_delay
from baselines import LQG, Constant
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite

RIGS, DELAY = 12, 4


def short(name, rigs):
    return replace(suite(name, rigs), env={"duration": 20.0})


@pytest.fixture(scope="module")
def content(trained, tmp_path_factory):
    docs = tmp_path_factory.mktemp("docs")
    found = {
        "command": "the command",
        "provenance": {"date": "today", "machine": "one"},
        "rigs": RIGS,
        "delays": [DELAY],
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(noise_and_delay, "suite", short)
        found["environments"] = shares(RIGS, trained, [DELAY])
    (docs / "agents").mkdir()
    (docs / noise_and_delay.FILE).write_text(json.dumps(found))
    return read_shares(docs)


@pytest.mark.slow
def test_every_policy_is_there_at_every_noise_and_delay(content):
    assert {env_id: list(map(float, found)) for env_id, found in content["environments"].items()} == {
        env_id: list(noises) for env_id, noises in NOISES.items()
    }
    names = {env_id: set(found["1"]) for env_id, found in content["environments"].items()}
    assert names["DrillRig-v0"] - names["DrillRigSurface-v0"] == {"`ppo`"}
    tables = [table for by_noise in content["environments"].values() for table in by_noise.values()]
    every = [found for table in tables for found in table.values()]
    assert {len(one) for one in every} == {1}


def test_shares_are_those_of_the_suite_with_that_noise_and_delay(content):
    found = content["environments"]["DrillRigSurface-v0"]["2"]
    drawn = short("default", RIGS)
    late = {"sensors": "surface", "noise": 2.0, "delay": DELAY}
    told = score(run(LQG(sensors="surface", delay=DELAY), drawn, **late))["mitigated"].mean()
    assert found[TOLD][0] == pytest.approx(told)
    alone = score(run(Constant(sensors="surface"), drawn, **late))["mitigated"].mean()
    np.testing.assert_allclose(found["action 0, same drive"], alone)


def test_the_page_has_a_table_each_and_the_picture_a_panel_each(content):
    text = section(content)
    assert text.count("| action 0, same drive |") == 4
    assert "`DrillRigSurface-v0`, twice the usual noise:" in text
    assert "0.4 s late" in text
    assert section(None) == ""
    assert len(plot_noise_and_delay(content).figure.axes) == 4


def test_every_agent_has_a_look_of_its_own(content):
    """In one legend over panels that share no agent."""
    by_noise = {"`one`": [0.5], "`two`": [0.4], TOLD: [0.9], "`lqg`": [0.6], "action 0, same drive": [0.3]}
    later = {**by_noise, "`three`": [0.3]}
    del later["`one`"]
    figure = plot_noise_and_delay({**content, "environments": {"A": {"0": by_noise}, "B": {"1": later}}}).figure
    (legend,) = figure.legends
    assert {"one", "two", "three"} < {text.get_text() for text in legend.get_texts()}
    looks = {(line.get_color(), line.get_linestyle(), line.get_marker()) for line in legend.legend_handles}
    assert len(looks) == len(legend.get_texts()) == 6


def test_nothing_is_found_where_it_has_not_run(tmp_path):
    assert read_shares(tmp_path) is None
