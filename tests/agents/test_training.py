import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from agents.run_folder import is_run, load_policy, read_config
from agents.training import Training, train

SMALL = {"n_envs": 8, "n_steps": 16, "batch_size": 64, "n_epochs": 1}
ROOT = Path(__file__).parents[2]


def small(folder, **changes):
    values = {"n_timesteps": 512, "hyperparams": SMALL, "log_folder": folder, "tensorboard": False, "progress": False}
    return Training(**{**values, **changes})


def test_run_folder_holds_the_model_and_what_made_it(tmp_path):
    folder = train(small(tmp_path, seed=3))
    config = read_config(folder)
    assert (config["algorithm"], config["seed"]) == ("ppo", 3)
    assert config["hyperparameters"]["n_steps"] == 16
    assert config["provenance"]["versions"]["stable-baselines3"]
    assert is_run(folder)
    actions, _ = load_policy(folder).predict(np.zeros((4, 11), np.float32), deterministic=True)
    assert actions.shape == (4, 1)
    assert train(small(tmp_path)).name == "ppo_2"


def test_same_seed_same_agent_and_another_seed_another(tmp_path):
    observations = np.random.default_rng(0).normal(size=(20, 11)).astype(np.float32)
    actions = [
        load_policy(train(small(tmp_path, seed=s))).predict(observations, deterministic=True)[0] for s in (1, 1, 2)
    ]
    np.testing.assert_array_equal(actions[0], actions[1])
    assert not np.array_equal(actions[0], actions[2])


def test_sac_trains(tmp_path):
    folder = train(
        small(tmp_path, algorithm="sac", hyperparams={"n_envs": 4, "learning_starts": 100, "batch_size": 32})
    )
    assert load_policy(folder).num_timesteps >= 512


def test_interrupt_keeps_what_was_learnt(tmp_path, monkeypatch):
    from stable_baselines3 import PPO

    def interrupted(self, *args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr(PPO, "learn", interrupted)
    folder = train(small(tmp_path))
    assert (folder / "model.zip").is_file()


def test_bad_settings_are_refused_before_anything_is_written(tmp_path):
    for changes, message in (
        ({"hyperparams": {"gama": 1}}, "did you mean gamma"),
        ({"seed": -1}, "seed = -1"),
        ({"seed": 10**9}, "seed"),
        ({"env_kwargs": {"sensors": "none"}}, "sensors"),
    ):
        with pytest.raises(ValueError, match=message):
            train(small(tmp_path / "runs", **changes))
    assert not (tmp_path / "runs").exists()


def command(*arguments, folder):
    return subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=False)


def test_command_lines_train_and_compare(tmp_path):
    settings = [f"{name}:{value}" for name, value in SMALL.items()]
    trained = command(
        str(ROOT / "train.py"),
        "ppo",
        "-n",
        "512",
        "--no-progress",
        "--no-tensorboard",
        "-params",
        *settings,
        folder=tmp_path,
    )
    assert trained.returncode == 0, trained.stderr
    assert (tmp_path / "runs/ppo_1/model.zip").is_file()
    compared = command(str(ROOT / "eval.py"), "constant", "runs/ppo_1", "--rigs", "20", folder=tmp_path)
    assert compared.returncode == 0, compared.stderr
    assert "ppo_1" in compared.stdout
    names = {path.name for path in (tmp_path / "results").iterdir()}
    assert {"results.csv", "results.json", "histories_default.png", "map_default.png", "map_chapter.png"} <= names
    estimates = json.loads((tmp_path / "results/results.json").read_text())["estimates"]
    assert set(estimates) == {"default", "chapter"}


def test_command_lines_explain_mistakes(tmp_path):
    wrong = command(str(ROOT / "eval.py"), "constnt", folder=tmp_path)
    assert wrong.returncode == 2
    assert "did you mean constant" in wrong.stderr
    wrong = command(str(ROOT / "train.py"), "ppo", "-params", "gamma", folder=tmp_path)
    assert wrong.returncode == 2
    assert "gamma:0.98" in wrong.stderr
