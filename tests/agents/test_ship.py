import json
import shutil

import numpy as np
import pytest

from agents.endurance import endurance
from agents.policy.action_zero import ActionZero
from agents.policy.run_folder import load_policy, read_config, read_seeds, shipped
from agents.shipping import ship as shipping
from agents.shipping.ship import median_seed, ship
from baselines import SoftTorque
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import default_suite


def scores_of(shares, costs):
    """Scores of ten rigs a seed."""
    seeds = np.repeat([str(seed) for seed in range(len(shares))], 10)
    mitigated = np.concatenate([np.arange(10) < 10 * share for share in shares])
    return {"seed": seeds, "mitigated": mitigated, "cost": np.repeat(costs, 10).astype(float)}


@pytest.mark.parametrize(
    ("shares", "costs", "median"),
    [
        ((0.9, 0.1, 0.5, 0.3, 0.7), (1, 1, 1, 1, 1), "2"),
        ((0.5, 0.5, 0.5, 0.9, 0.1), (3, 1, 2, 0, 0), "2"),
        ((0.9, 0.1, 0.5, 0.3), (1, 1, 1, 1), "3"),
    ],
    ids=["by share", "equals by cost", "the worse of the middle two"],
)
def test_median_seed(shares, costs, median):
    assert median_seed(scores_of(shares, costs)) == median


def test_shipped_agent_is_that_of_the_chosen_seed(trained, five_seeds):
    folder, about = trained / "ppo", read_seeds(trained / "ppo")
    chosen = five_seeds / f"seed_{about['shipped']}"
    for file in ("config.json", "model.zip", "evaluations.npz"):
        assert (folder / file).read_bytes() == (chosen / file).read_bytes()
    shares = {seed: (one["scores"]["mitigated"], -one["scores"]["cost"]) for seed, one in about["seeds"].items()}
    assert sorted(shares.values())[2] == shares[str(about["shipped"])]
    actions, _ = load_policy(folder).predict(np.zeros((2, 12), np.float32))
    assert actions.shape == (2, 1)


def test_all_seeds_are_told_of(trained):
    about = read_seeds(trained / "ppo")
    assert list(about["seeds"]) == ["0", "1", "2", "3", "4"]
    for one in about["seeds"].values():
        assert one["seconds"] > 0
        assert one["timesteps"] == [0, 128, 256]
        assert len(one["mitigated"]) == 3
    assert {name: list(tables) for name, tables in about["pooled"].items()} == {
        "default": ["main", "hardness", "others"],
        "load": ["main"],
    }
    assert sum(one["count"] for one in about["pooled"]["default"]["hardness"].values()) == 5 * 12
    assert about["pooled"]["default"]["main"]["calm"]["count"] == 5 * 12
    assert about["alone"]["default"]["main"]["calm"]["count"] == 12
    calm = [one["scores"]["calm"] for one in about["seeds"].values()]
    assert about["pooled"]["default"]["main"]["calm"]["value"] == pytest.approx(np.mean(sorted(calm)[1:4]))
    assert list(about["endurance"]) == ["60", "120", "300", "600"]
    assert "NaN" not in (trained / "ppo" / "seeds.json").read_text()


@pytest.mark.slow
def test_kept_results_are_not_made_again(trained, five_seeds, tmp_path, monkeypatch):
    def never(*_arguments, **_keywords):
        raise AssertionError("was run again")

    monkeypatch.setattr("drillrig_env.evaluation.pieces.run", never)
    ship(five_seeds, "ppo", 12, ["default", "load"], trained.parent / "results", tmp_path)
    again, before = read_seeds(tmp_path / "ppo"), read_seeds(trained / "ppo")
    assert (again["pooled"], again["shipped"]) == (before["pooled"], before["shipped"])
    with pytest.raises(ValueError, match=r"results of another making.*; --results names another folder"):
        ship(five_seeds, "ppo", 13, ["default"], trained.parent / "results", tmp_path)


def test_too_few_and_unfinished_seeds_are_refused(five_seeds, tmp_path, capsys):
    shutil.copytree(five_seeds, tmp_path / "runs")
    (tmp_path / "runs" / "seed_3" / "checkpoint.npz").touch()
    with pytest.raises(ValueError, match="seed_3 is not finished"):
        ship(tmp_path / "runs", "ppo", 12, trained=tmp_path)
    shutil.rmtree(tmp_path / "runs" / "seed_3")
    with pytest.raises(SystemExit):
        shipping.main([str(tmp_path / "runs"), "--name", "ppo"])
    assert "4 training seeds; allowed: >= 5" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["", "lqg", "a b", "../up", ".hidden", "ä"])
def test_names_under_which_no_agent_would_be_found_are_refused(name, five_seeds, tmp_path):
    with pytest.raises(ValueError, match="allowed: letters, digits, _ and -, and not the name of a law"):
        ship(five_seeds, name, 12, trained=tmp_path)


def test_seeds_of_another_rig_and_damaged_ones_are_refused_before_anything_is_run(five_seeds, tmp_path):
    runs, damaged = tmp_path / "runs", tmp_path / "runs" / "seed_2"
    shutil.copytree(five_seeds, runs)
    (damaged / "evaluations.npz").write_bytes(b"PK")
    with pytest.raises(ValueError, match=r"evaluations.npz is damaged: .*; train this seed again"):
        ship(runs, "ppo", 12, trained=tmp_path)
    shutil.copyfile(five_seeds / "seed_2" / "evaluations.npz", damaged / "evaluations.npz")
    config = read_config(damaged)
    (damaged / "config.json").write_text(json.dumps({name: config[name] for name in config if name != "provenance"}))
    with pytest.raises(ValueError, match=r"seed_2 does not tell how it was trained \('provenance'\)"):
        ship(runs, "ppo", 12, trained=tmp_path)
    config["env_kwargs"]["rig"] = {"J_1": 2.0}
    (damaged / "config.json").write_text(json.dumps(config))
    with pytest.raises(ValueError, match="seed_2 has a rig of its own, and the suites are of the laboratory's"):
        ship(runs, "ppo", 12, trained=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["runs"]


def test_what_was_shipped_stays_whole_until_the_next_is(trained, five_seeds, tmp_path, monkeypatch):
    folder = tmp_path / "ppo"
    shutil.copytree(trained / "ppo", folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}

    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(shipping, "json_text", stopped)
    monkeypatch.setattr(shipping, "endurance", lambda *_, **__: {})
    monkeypatch.setattr(shipping, "failures_of", lambda *_: ("", {}))
    monkeypatch.setattr(shipping, "in_its_place", lambda *_: {})
    with pytest.raises(KeyboardInterrupt):
        ship(five_seeds, "ppo", 12, ["default", "load"], trained.parent / "results", tmp_path)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert shipped(tmp_path) == ["ppo"]
    (tmp_path / ".ppo.killed").mkdir()
    (tmp_path / ".ppo.killed" / "config.json").touch()
    assert shipped(tmp_path) == ["ppo"]


def test_time_of_a_training_goes_on_after_a_stop(five_seeds, tmp_path):
    from agents.training.progress import ShowProgress, read_progress

    config = read_config(five_seeds / "seed_0")
    (tmp_path / "progress.json").write_text(json.dumps({"seconds": 100.0}))
    shown = ShowProgress(tmp_path, config["hyperparameters"]["n_timesteps"], show=False)
    shown.num_timesteps = 0
    shown._on_training_start()
    shown.close()
    assert 100.0 <= read_progress(tmp_path)["seconds"] < 110.0


def test_endurance_after_the_length_of_an_episode_is_the_verdict_of_the_episode(trained):
    """Steady at the target: on the soft drive that calms most rigs, for good."""
    policy = ActionZero(load_policy(trained / "ppo").environment | {"drive": SoftTorque().drive})
    told = []
    held = endurance(policy, 40, (20.0, 60.0, 120.0), lambda *done: told.append(done))
    assert told == [(step, 1200) for step in range(100, 1300, 100)]
    mitigated = score(run(SoftTorque(), default_suite(40)))["mitigated"].mean()
    assert held["60"] == pytest.approx(mitigated)
    assert held["20"] < held["60"] <= held["120"]
