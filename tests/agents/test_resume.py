import contextlib
import errno
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from agents.policy.environment import batch_of, make_environment
from agents.policy.run_folder import CHECKPOINT, MODEL, TRAINED, is_finished, load_policy, read_config
from agents.training.checkpoint import load_checkpoint, save_checkpoint, save_model
from agents.training.hyperparameters import algorithm_class
from agents.training.progress import ShowProgress, read_progress
from agents.training.settings import Training
from agents.training.train import resume, train
from drillrig_env import files
from drillrig_env.command_line import Failed, Terminated
from drillrig_env.files import LOCK
from tests.agents import tiny

ROOT = Path(__file__).parents[2]

PPO = {**tiny.PPO, "n_epochs": 2}
SAC = {**tiny.SAC, "train_freq": 8, "gradient_steps": 4}
HANDLERS = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
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


def interrupt_at(steps, monkeypatch, number=signal.SIGINT):
    """Press Ctrl-C once, or send another signal, in the middle of the rollout that passes so many steps."""
    pressed = []

    def press(self):
        if self.num_timesteps > steps and not pressed:
            pressed.append(True)
            signal.raise_signal(number)
        return True

    monkeypatch.setattr(ShowProgress, "_on_step", press)


@pytest.fixture(autouse=True)
def signals_as_in_a_terminal():
    """The signals' handlers of a program of its own, whatever runs the tests has set."""
    earlier = {s: signal.signal(s, h) for s, h in HANDLERS.items()}
    yield
    assert {s: signal.getsignal(s) for s in HANDLERS} == HANDLERS
    for number, handler in earlier.items():
        signal.signal(number, handler)


def stopped(*arguments, **changes):
    """Train until Ctrl-C, and return the folder."""
    settings = training(*arguments, **changes)
    with pytest.raises(KeyboardInterrupt) as stop:
        train(settings)
    assert f"to go on: python train.py --resume {settings.run_folder}" in stop.value.__notes__
    return settings.run_folder


def assert_same_agent(folder, other):
    one, two = (load_policy(path).model for path in (folder, other))
    assert one.num_timesteps == two.num_timesteps
    expected, found = one.policy.state_dict(), two.policy.state_dict()
    assert all(torch.equal(expected[name], found[name]) for name in expected)


FLEET = {"scenario": {"rigs": {"spread": {"string": 2.0}, "count": 3, "seed": 0}}}


@pytest.mark.parametrize(
    ("algorithm", "hyperparams", "env_kwargs"),
    [
        ("ppo", PPO, {}),
        ("ppo", {**PPO, "frame_stack": 3}, {"sensors": "surface", "delay": [1, 3]}),
        pytest.param("ppo", {**PPO, "anchor": 1.0}, {}, marks=pytest.mark.slow),
        ("sac", SAC, {}),
        pytest.param("sac", {**SAC, "anchor": 1.0}, {}, marks=pytest.mark.slow),
        ("ppo_lstm", LSTM, {}),
        ("ppo_asymmetric", tiny.ASYMMETRIC, FLEET),
        ("ppo", {**PPO, "frame_stack": 3, "observer": "lqg"}, {"sensors": "surface"}),
        ("ppo_asymmetric", {**tiny.ASYMMETRIC, "observer": "lqg"}, FLEET),
    ],
    ids=[
        *("ppo", "ppo, frames, noise and delay", "ppo, anchored", "sac", "sac, anchored", "ppo_lstm", "ppo_asymmetric"),
        *("ppo, frames, observer", "ppo_asymmetric, observer"),
    ],
)
def test_cut_and_resumed_ends_bit_for_bit_like_uncut(algorithm, hyperparams, env_kwargs, tmp_path, monkeypatch):
    if algorithm in ("ppo_lstm", "ppo_asymmetric"):
        pytest.importorskip("sb3_contrib")
    settings = {"env_kwargs": {"duration": 3.0, **env_kwargs}}
    if algorithm == "ppo_asymmetric":
        settings["env_id"] = "DrillRigUnknown-v0"
    uncut = train(training(tmp_path / "uncut", algorithm, hyperparams, **settings))
    interrupt_at(300, monkeypatch)
    cut = stopped(tmp_path / "cut", algorithm, hyperparams, **settings)
    assert (cut / CHECKPOINT).is_file()
    assert 300 <= load_policy(cut).model.num_timesteps <= 400
    assert not is_finished(cut)
    np.random.default_rng().random()
    torch.manual_seed(99)
    np.random.seed(99)  # noqa: NPY002
    resume(cut, progress=False)
    assert not (cut / CHECKPOINT).exists()
    assert_same_agent(cut, uncut)
    with np.load(uncut / "evaluations.npz") as a, np.load(cut / "evaluations.npz") as b:
        for name in ("timesteps", "results", "mitigated"):
            np.testing.assert_array_equal(a[name], b[name])


def test_stop_finishes_the_rollout_and_keeps_the_model(tmp_path, monkeypatch):
    interrupt_at(130, monkeypatch)
    assert load_policy(stopped(tmp_path / "run")).model.num_timesteps == 256


def test_sigterm_stops_as_ctrl_c_does_and_is_told_apart(tmp_path, monkeypatch):
    interrupt_at(130, monkeypatch, signal.SIGTERM)
    with pytest.raises(Terminated):
        train(training(tmp_path / "run"))
    assert load_policy(tmp_path / "run").model.num_timesteps == 256


def test_second_interrupt_stops_at_once_and_keeps_the_last_checkpoint(tmp_path, monkeypatch):
    def press(self):
        if self.num_timesteps > 300:
            signal.raise_signal(signal.SIGINT)
        return True

    monkeypatch.setattr(ShowProgress, "_on_step", press)
    folder = stopped(tmp_path / "run", save_freq=128)
    assert load_policy(folder).model.num_timesteps < 384
    monkeypatch.undo()
    resume(folder, progress=False)
    assert load_policy(folder).model.num_timesteps == 768


def test_a_stop_during_the_last_save_comes_too_late(tmp_path, monkeypatch):
    def press(path, model):
        signal.raise_signal(signal.SIGINT)
        save_model(path, model)

    monkeypatch.setattr("agents.training.train.save_model", press)
    assert is_finished(train(training(tmp_path / "run")))


def test_resume_continues_the_schedule(tmp_path, monkeypatch):
    interrupt_at(300, monkeypatch)
    folder = stopped(tmp_path / "run")
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
    with pytest.raises(ValueError, match="the run is finished"):
        resume(folder)


def test_a_full_disk_at_the_end_leaves_the_checkpoint(tmp_path, monkeypatch):
    uncut = train(training(tmp_path / "uncut"))

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("agents.training.train.save_model", full)
    with pytest.raises(OSError, match="No space left") as end:
        train(training(tmp_path / "run"))
    monkeypatch.undo()
    assert "could not be written" in end.value.__notes__[0]
    resume(tmp_path / "run", progress=False)
    assert_same_agent(tmp_path / "run", uncut)


@pytest.mark.parametrize("file", ["model.zip", "best_model.zip", "evaluations.npz", CHECKPOINT, "progress.json"])
def test_a_full_disk_never_leaves_half_a_file(file, tmp_path, monkeypatch):
    """From the second write of a file on, its disk is full; of evaluations, that at step 0 is written before."""
    written, whole = [], 2 if file == "evaluations.npz" else 1
    flush = files._flush

    def full(path):
        written.append(path.name)
        mine = [name for name in written if name.startswith(f".{file.split('.')[0]}.")]
        if len(mine) > whole and path.name == mine[-1]:
            path.write_bytes(path.read_bytes()[:100])
            raise OSError(errno.ENOSPC, "No space left on device")
        flush(path)

    monkeypatch.setattr(files, "_flush", full)
    with contextlib.suppress(OSError):
        train(training(tmp_path / "run", eval_freq=128, save_freq=128))
    monkeypatch.undo()
    kept = {path.name for path in (tmp_path / "run").iterdir()}
    assert kept <= {LOCK, "config.json", "model.zip", "best_model.zip", "evaluations.npz", CHECKPOINT, "progress.json"}
    assert CHECKPOINT in kept or is_finished(tmp_path / "run")
    if not is_finished(tmp_path / "run"):
        resume(tmp_path / "run", progress=False)
    assert load_policy(tmp_path / "run").model.num_timesteps == 768


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows has no SIGKILL")
def test_killed_in_the_last_save_it_goes_on_from_the_checkpoint(tmp_path):
    uncut = train(training(tmp_path / "uncut"))
    run = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path / "run")], cwd=ROOT, check=False)
    assert run.returncode == -signal.SIGKILL
    assert not (tmp_path / "run" / "model.zip").exists()
    assert (tmp_path / "run" / CHECKPOINT).is_file()
    resume(tmp_path / "run", progress=False)
    assert_same_agent(tmp_path / "run", uncut)


KILLED = """
import os, signal, sys
from pathlib import Path
from stable_baselines3 import PPO
from agents.training.train import train
from tests.agents.test_resume import training

def killed(self, path, **given):
    if getattr(path, "name", "").startswith(".model."):
        path.write_bytes(b"half of it")
        os.kill(os.getpid(), signal.SIGKILL)
    save(self, path, **given)

save, PPO.save = PPO.save, killed
train(training(Path(sys.argv[1])))
"""


def test_one_process_at_a_time_trains_in_a_folder(tmp_path, monkeypatch):
    interrupt_at(130, monkeypatch)
    folder = stopped(tmp_path / "run")
    with files.owned(folder), pytest.raises(BlockingIOError, match=f"run is in use by process {os.getpid()}"):
        resume(folder)
    resume(folder, progress=False)


def test_a_finished_run_is_left_as_it_is(tmp_path):
    for name in ("model.zip", "config.json"):
        shutil.copy(TRAINED / "sac_soft" / name, tmp_path)
    with pytest.raises(ValueError, match="nothing to go on with: the run is finished"):
        resume(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["config.json", "model.zip"]


def test_damaged_evaluations_are_passed_over(tmp_path, monkeypatch, capsys):
    interrupt_at(300, monkeypatch)
    folder = stopped(tmp_path / "run")
    path = folder / "evaluations.npz"
    path.write_bytes(path.read_bytes()[:200])
    resume(folder, progress=False)
    assert "evaluations.npz is damaged" in capsys.readouterr().out
    with np.load(path) as saved:
        assert saved["timesteps"].tolist() == [384, 512, 768]


def test_a_damaged_checkpoint_is_named_and_without_it_the_training_begins_again(tmp_path, monkeypatch):
    uncut = train(training(tmp_path / "uncut"))
    interrupt_at(300, monkeypatch)
    folder = stopped(tmp_path / "run")
    path = folder / CHECKPOINT
    whole = path.read_bytes()
    for damaged in (whole[: len(whole) // 2], b"nothing"):
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"checkpoint\.npz is .*damaged.*; remove it, and --resume begins"):
            resume(folder)
    path.unlink()
    resume(folder, progress=False)
    assert_same_agent(folder, uncut)


def test_a_run_whose_model_is_damaged_does_not_begin_again_in_silence(tmp_path):
    folder = train(training(tmp_path / "run"))
    whole = (folder / MODEL).read_bytes()
    (folder / MODEL).write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match=r"model\.zip is damaged; remove it, and --resume begins the training again"):
        resume(folder)
    (folder / MODEL).unlink()
    resume(folder, progress=False)
    assert (folder / MODEL).read_bytes()[:2] == whole[:2]


def test_an_error_while_learning_keeps_the_model_and_says_how_to_go_on(tmp_path, monkeypatch):
    def broken(self):
        if self.num_timesteps > 300:
            raise ValueError("rig 3: the state is not finite")
        return True

    monkeypatch.setattr(ShowProgress, "_on_step", broken)
    with pytest.raises(Failed, match="the training failed: rig 3: the state is not finite") as end:
        train(training(tmp_path / "run", save_freq=128))
    assert f"to go on: python train.py --resume {tmp_path / 'run'}" in end.value.__notes__
    monkeypatch.undo()
    resume(tmp_path / "run", progress=False)


def test_terms_of_a_reward_are_called_where_this_process_has_them(tmp_path):
    (tmp_path / "terms.py").write_text(
        "from drillrig_env import RewardTerms\n\ndef slow(bit_speed):\n    return -bit_speed\n\n"
        'mine = RewardTerms("slow", slow)\n'
    )
    environment = {"duration": 3.0, "reward": f"{tmp_path}/terms.py:mine"}
    envs = [make_environment("DrillRig-v0", 8, 0, environment) for _ in range(2)]
    model = algorithm_class("ppo")("MlpPolicy", envs[0], n_steps=16, batch_size=64).learn(128)
    address = batch_of(envs[0]).core._settings["address"].copy()
    batch_of(envs[0]).core._settings["address"] = 1  # as if it were another process
    save_checkpoint(tmp_path / CHECKPOINT, model)
    load_checkpoint(tmp_path / CHECKPOINT, "ppo", envs[1])
    assert batch_of(envs[1]).core._settings["address"] == address
