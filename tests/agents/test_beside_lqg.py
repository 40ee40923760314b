"""Beside LQG: which rigs only one of the two frees, and what either asks for where the agent acts."""

import numpy as np
import pytest

from agents.beside_lqg import HardRig, hard_rig, results_with_both, section
from agents.pictures.beside_lqg import Listening, plot_beside
from agents.pictures.one_rig import typical_rig
from baselines import LQG, Constant
from drillrig_env.evaluation.results import Results
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.suites import default_suite


def scores(mitigated, hardness, calm):
    count = len(mitigated)
    return {
        "seed": np.full(count, ""),
        "episode": np.arange(count),
        "speed_target": np.linspace(1.0, 2.0, count),
        "normal_force": np.linspace(10.0, 20.0, count),
        "hardness": np.array(hardness, dtype=float),
        "mitigated": np.array(mitigated, dtype=bool),
        "time_to_calm": np.array(calm, dtype=float),
    }


@pytest.fixture
def results():
    found = Results({"suites": {"default": {"rigs": 5}, "wide": {"rigs": 5}}}, {})
    hardness = [1, 2, 3, 4, 5]
    found.add("default", "lqg", scores([1, 1, 0, 0, 1], hardness, [9, 7, 60, 60, 9]))
    found.add("default", "ppo", scores([1, 1, 1, 1, 0], hardness, [8, 8, 9, 9, 60]))
    found.add("wide", "lqg", scores([1, 1, 1, 1, 0], hardness, [9, 9, 9, 9, 60]))
    found.add("wide", "ppo", scores([1, 1, 1, 1, 1], hardness, [9, 9, 9, 9, 9]))
    return found


def test_rigs_are_counted_by_who_frees_them(results):
    text = section({"ppo": results})
    assert "| `default` | 5 | 2 | 2 | 1 | 0 | 1 | 1 |" in text
    assert "| `wide` | 5 | 4 | 1 | 0 | 0 | 0 | 0 |" in text
    assert "images/agents/beside_ppo.png" in text
    assert section({}) == ""


def test_the_rig_is_the_hardest_of_the_suite_with_most(results):
    assert hard_rig(results, "ppo") == HardRig("default", 3, 4.0, 17.5, 1.75)
    alone = Results()
    for name in ("lqg", "ppo"):
        alone.add("default", name, results.scores["default"]["lqg"])
    assert hard_rig(alone, "ppo") is None
    assert "beside_ppo" not in section({"ppo": alone})
    with pytest.raises(ValueError, match="ppo mitigates no rig that lqg does not"):
        plot_beside("ppo", alone)


def test_results_without_either_are_left_out(results):
    wanted = {"ppo": "DrillRig-v0", "sac": "DrillRig-v0", "ppo_surface": "DrillRigSurface-v0"}
    assert list(results_with_both({"DrillRig-v0": results}, wanted)) == ["ppo"]


@pytest.mark.slow
def test_who_listens_changes_nothing_and_says_what_it_would_do():
    alone = default_suite().only(typical_rig().place)
    listening = Listening(LQG(), Constant())
    np.testing.assert_array_equal(run(listening, alone).average, run(LQG(), alone).average)
    said = np.array(listening.said)
    assert said.shape == (600, 2)
    assert np.abs(said[:, 0]).max() == 1.0
    assert np.mean(said[:, 0] == said[:, 1]) < 0.1
    both = Listening(Constant(), LQG())
    run(both, alone)
    assert np.ptp(np.array(both.said)[:, 1]) > 0.5  # it remembers: the rig shakes on under its eyes


def test_the_picture_shows_that_rig(results, trained):
    picture = plot_beside("ppo", results, trained)
    assert "suite default (rig 3, q = 4.0, N_1 = 17.5" in picture.caption
    law, agent, rates = picture.figure.axes[:3]
    assert {law.get_title(), agent.get_title(), rates.get_title()} >= {"lqg", "ppo"}
