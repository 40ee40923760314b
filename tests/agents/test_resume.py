import signal

import numpy as np
import pytest
import torch

from agents.policy.run_folder import CHECKPOINT, load_policy, read_config
from agents.training.progress import ShowProgress, read_progress
from agents.training.train import Training, resume, train

PPO = {"n_envs": 8, "n_steps": 16, "batch_size": 64, "n_epochs": 2}
SAC = {"n_envs": 4, "learning_starts": 100, "batch_size": 32, "train_freq": 8, "gradient_steps": 4}
LSTM = {**PPO, "policy_kwargs": {"lstm_hidden_size": 8}}


def training(folder, algorithm="ppo", hyperparams=None, **changes):
    values = {
        "n_timesteps": 768,
        "env_kwargs": {"duration": 3.0},
        "eval_freq": 256,
        "eval_episodes": 5,
        "tensorboard": False,
        "progress": False,
    }
    return Training(algorithm=algorithm, hyperparams=hyperparams or PPO, run_folder=folder, **{**values, **changes})


def interrupt_at(steps, monkeypatch):
    """Press Ctrl-C once, in the middle of the rollout that passes so many steps."""
    pressed = []

    def press(self):
        if self.num_timesteps > steps and not pressed:
            pressed.append(True)
            signal.raise_signal(signal.SIGINT)
        return True

    monkeypatch.setattr(ShowProgress, "_on_step", press)


def parameters(folder):
    return load_policy(folder).model.policy.state_dict()


@pytest.mark.parametrize(
    ("algorithm", "hyperparams", "env_kwargs"),
    [
        ("ppo", PPO, {}),
        ("ppo", {**PPO, "frame_stack": 3}, {"sensors": "surface", "delay": [1, 3]}),
        ("sac", SAC, {}),
        ("ppo_lstm", LSTM, {}),
    ],
    ids=["ppo", "ppo, frames, noise and delay", "sac", "ppo_lstm"],
)
def test_cut_and_resumed_ends_bit_for_bit_like_uncut(algorithm, hyperparams, env_kwargs, tmp_path, monkeypatch):
    if algorithm == "ppo_lstm":
        pytest.importorskip("sb3_contrib")
    settings = {"env_kwargs": {"duration": 3.0, **env_kwargs}}
    uncut = train(training(tmp_path / "uncut", algorithm, hyperparams, **settings))
    interrupt_at(300, monkeypatch)
    cut = train(training(tmp_path / "cut", algorithm, hyperparams, **settings))
    assert (cut / CHECKPOINT).is_file()
    stopped = load_policy(cut).model.num_timesteps
    assert 300 <= stopped <= 400
    np.random.default_rng().random()
    torch.manual_seed(99)
    np.random.seed(99)  # noqa: NPY002
    resume(cut, progress=False)
    assert not (cut / CHECKPOINT).exists()
    assert load_policy(cut).model.num_timesteps == load_policy(uncut).model.num_timesteps
    expected, found = parameters(uncut), parameters(cut)
    assert all(torch.equal(expected[name], found[name]) for name in expected)
    with np.load(uncut / "evaluations.npz") as a, np.load(cut / "evaluations.npz") as b:
        for name in ("timesteps", "results", "mitigated"):
            np.testing.assert_array_equal(a[name], b[name])


def test_stop_finishes_the_rollout_and_tells_how_to_go_on(tmp_path, monkeypatch, capsys):
    interrupt_at(130, monkeypatch)
    folder = train(training(tmp_path / "run"))
    assert load_policy(folder).model.num_timesteps == 256
    assert f"--resume {folder}" in capsys.readouterr().out
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_second_interrupt_stops_at_once_and_keeps_the_last_checkpoint(tmp_path, monkeypatch):
    def press(self):
        if self.num_timesteps > 300:
            signal.raise_signal(signal.SIGINT)
        return True

    monkeypatch.setattr(ShowProgress, "_on_step", press)
    folder = train(training(tmp_path / "run", save_freq=128))
    assert load_policy(folder).model.num_timesteps < 384
    monkeypatch.undo()
    resume(folder, progress=False)
    assert load_policy(folder).model.num_timesteps == 768


def test_resume_continues_the_schedule(tmp_path, monkeypatch):
    interrupt_at(300, monkeypatch)
    folder = train(training(tmp_path / "run"))
    seen = []

    def rates(self):
        seen.append(self.model.policy.optimizer.param_groups[0]["lr"])

    monkeypatch.setattr(ShowProgress, "_on_rollout_end", rates)
    resume(folder, progress=False)
    first = float(read_config(folder)["hyperparameters"]["learning_rate"].removeprefix("lin_"))
    assert seen == pytest.approx([first * (1 - steps / 768) for steps in (384, 512, 640)])
    assert read_progress(folder)["steps"] == 768


def test_nothing_to_resume_is_said(tmp_path):
    with pytest.raises(ValueError, match="not the folder of a run"):
        resume(tmp_path)
    folder = train(training(tmp_path / "run"))
    with pytest.raises(ValueError, match="it is finished"):
        resume(folder)
