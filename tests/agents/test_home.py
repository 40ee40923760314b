"""Agents that are at home in another suite than `default`: chosen, shown and listed by that one."""

import csv

import pytest

pytest.importorskip("sb3_contrib")

from agents.policy.run_folder import read_seeds
from agents.shipping.card import card
from agents.shipping.home import suites_of
from agents.shipping.ship import ship
from agents.training.settings import Training
from agents.training.train import train
from docs.make.agents import page
from drillrig_env.env.registration import ENVIRONMENTS
from drillrig_env.evaluation.suites import OF_ONE_RIG, SUITES, home_suite, suite
from tests.agents.tiny import ASYMMETRIC


def test_every_environment_has_a_home_among_its_suites():
    homes = {env_id: home_suite(env_id) for env_id in ENVIRONMENTS}
    assert homes == {
        "DrillRig-v0": "default",
        "DrillRigSurface-v0": "default",
        "DrillRigUnknown-v0": "unknown",
        "DrillRigDrift-v0": "drift",
    }
    for env_id, home in homes.items():
        assert {home, *OF_ONE_RIG} <= set(suites_of(env_id)) <= set(SUITES)
        assert suite(home, 1).env_id in (None, env_id)


@pytest.mark.slow
def test_an_agent_of_unknown_rigs_is_shipped_by_their_suite(trained, tmp_path):
    fleet = {"rigs": {"spread": {"string": 2.0}, "count": 3, "seed": 0}, "spread": 0.0}
    for seed in range(5):
        train(
            Training(
                "ppo_asymmetric",
                "DrillRigUnknown-v0",
                seed=seed,
                n_timesteps=160,
                hyperparams=ASYMMETRIC,
                env_kwargs={"scenario": fleet},
                eval_freq=80,
                eval_episodes=2,
                run_folder=tmp_path / "runs" / f"seed_{seed}",
                tensorboard=False,
                progress=False,
            )
        )
    with pytest.raises(ValueError, match="suite = wid is not allowed; allowed: unknown, unknown_hard, drift, chapter"):
        ship(tmp_path / "runs", "lost", 2, ["wid"], trained=tmp_path)
    ship(tmp_path / "runs", "lost", 2, ["default"], trained=trained)
    about = read_seeds(trained / "lost")
    assert {name: list(tables) for name, tables in about["pooled"].items()} == {
        "default": ["main"],
        "unknown": ["main", "hardness", "others"],
    }
    assert about["rigs"]["unknown"] == 32
    assert list(about["action_zero"]["suites"]["unknown"]) == ["main", "hardness", "others"]
    rows = list(csv.DictReader((trained / "lost" / "failures.csv").read_text().splitlines()))
    assert {row["suite"] for row in rows} == {"unknown"}
    assert sum(one["failed"] for one in about["failures"].values()) == len(rows)
    text = card("lost", trained)
    for words in ("Every seed in `unknown`", "remembers what it saw", "nor the friction, nor the rig", "| `unknown` |"):
        assert words in text
    written = page(tmp_path, trained)
    assert "Where nobody knows the rig" in written
    assert "[`lost`](../agents/trained/lost/README.md)" in written
