"""Trained agents in an evaluation: their seeds as one policy, and the conditions that they bring."""

import pytest

from drillrig_env.cli import evaluate as command
from drillrig_env.evaluation.contestants import contestant_of
from drillrig_env.evaluation.store import read
from drillrig_env.policy import find_policy
from tests.agents.tiny import PPO

FEW = ["--suite", "default", "--rigs", "8", "--no-pictures"]


def evaluate(*arguments):
    return command.main([*map(str, arguments)], prog="python eval.py")


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    from agents.training.settings import Training
    from agents.training.train import train

    folder = tmp_path_factory.mktemp("runs") / "tiny"
    for seed in (0, 1):
        train(
            Training(
                "ppo",
                seed=seed,
                n_timesteps=256,
                hyperparams={**PPO, "n_envs": 2, "n_steps": 64},
                run_folder=folder / f"seed_{seed}",
                eval_freq=-1,
                tensorboard=False,
                progress=False,
            )
        )
    return folder


def test_seeds_in_a_folder_are_one_policy(trained, tmp_path):
    assert evaluate("constant", trained, trained / "seed_1", *FEW, "--output", tmp_path) == 0
    results = read(tmp_path)
    scores = results.scores["default"]
    assert scores["tiny"]["seed"].tolist() == ["0"] * 8 + ["1"] * 8
    assert (scores["tiny"]["cost"][8:] == scores["seed_1"]["cost"]).all()
    assert results.config["policies"]["tiny"]["seeds"] == ["0", "1"]


def test_an_agent_is_shown_what_the_environment_shows_and_no_more(trained):
    contestant = contestant_of(find_policy(str(trained)), "DrillRig-v0", "tiny")
    assert contestant.env == {"sensors": "state", "noise": 0.0, "delay": (0, 0)}
    with pytest.raises(ValueError, match=r"tiny sees twist_12.*the sensors of DrillRigSurface-v0 do not show"):
        contestant_of(find_policy(str(trained)), "DrillRigSurface-v0", "tiny")


def test_runs_of_different_making_are_not_pooled(trained):
    config = trained / "seed_1" / "config.json"
    text = config.read_text()
    config.write_text(text.replace('"env_id": "DrillRig-v0"', '"env_id": "DrillRigSurface-v0"'))
    try:
        with pytest.raises(ValueError, match="not the seeds of one algorithm"):
            contestant_of(find_policy(str(trained)), "DrillRig-v0", "tiny")
    finally:
        config.write_text(text)


def test_noise_and_delay_of_a_training_are_everyones_and_said(tmp_path, capsys):
    from agents.training.train import Training, train

    folder = train(
        Training(
            "ppo",
            n_timesteps=128,
            hyperparams={**PPO, "n_envs": 2, "n_steps": 64},
            env_kwargs={"noise": 2.0, "delay": [1, 5]},
            run_folder=tmp_path / "noisy",
            eval_freq=-1,
            tensorboard=False,
            progress=False,
        )
    )
    evaluate("z_torque", folder, *FEW, "--output", tmp_path / "as_trained")
    assert "noisy was trained with the sensors of DrillRig-v0, noise 2.0, delay 1 to 5 steps" in capsys.readouterr().err
    evaluate("z_torque", *FEW, "--output", tmp_path / "standard")
    results, standard = read(tmp_path / "as_trained"), read(tmp_path / "standard")
    assert (results.config["noise"], results.config["delay"]) == (2.0, [1, 5])
    scores, plain = (one.scores["default"]["z_torque"] for one in (results, standard))
    assert (scores["hardness"] == plain["hardness"]).all()
    assert (scores["cost"] != plain["cost"]).all()


def test_a_surface_agent_brings_its_environment(tmp_path):
    assert evaluate("ppo_surface_soft", *FEW, "--output", tmp_path) == 0
    assert read(tmp_path).config["env"] == "DrillRigSurface-v0"
