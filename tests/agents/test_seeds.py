"""Several seeds side by side: stopped together within seconds, and gone on with, also where they had not begun."""

import io
import os
import signal
import subprocess
import sys
import threading
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest
import torch

from agents.policy.environment import batch_of, make_environment
from agents.policy.run_folder import CHECKPOINT, MODEL, is_finished, read_config, write_config
from agents.training import seeds
from agents.training.seeds import resume_seeds, train_seeds
from agents.training.settings import Training, checked_config
from agents.training.train import train
from drillrig_env import files
from drillrig_env.command_line import Failed
from drillrig_env.engine import Local, engine_at
from tests.agents.tiny import PPO

ROOT = Path(__file__).parents[2]
FLAGS = "--eval-freq -1 --no-tensorboard --env-kwargs duration:3.0 -params n_envs:8 n_steps:16 batch_size:64"
FLAGS += " imitation:null critic_iterations:0 frame_stack:1"


def small(folder, **changes):
    values = {"n_timesteps": 256, "hyperparams": PPO, "env_kwargs": {"duration": 3.0}, "eval_freq": -1}
    settings = {"run_folder": folder, "tensorboard": False, "progress": False}
    return Training(**{**values, **settings, **changes})


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals between processes")
@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_to_the_parent_stops_its_trainings_and_keeps_them(number, code, tmp_path):
    """The parent alone is told, as by `kill`, and the signal is one that it was started with as ignored."""
    command = [sys.executable, "-u", "train.py", *FLAGS.split(), "-n", "100000000", "--save-freq", "128"]
    command += ["--seeds", "3", "--jobs", "2", "--run-folder", str(tmp_path / "runs")]
    ignored = f"import os, signal, sys; signal.signal({number:d}, signal.SIG_IGN); os.execv(sys.argv[1], sys.argv[1:])"
    process = subprocess.Popen(
        [sys.executable, "-c", ignored, *command],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    begun = [tmp_path / "runs" / f"seed_{seed}" / CHECKPOINT for seed in (0, 1)]
    try:
        while not all(path.is_file() for path in begun):
            assert process.poll() is None, process.stdout.read()
            time.sleep(0.1)
        process.send_signal(number)
        said, _ = process.communicate(timeout=300)
    finally:
        process.kill()
    assert process.returncode == code, said
    assert f"to go on: python train.py --resume {tmp_path / 'runs'}" in said
    assert "seed_0: stopped" in said
    assert "seed_1: stopped" in said
    assert all(path.is_file() for path in begun)
    for seed in range(3):
        assert not is_finished(tmp_path / "runs" / f"seed_{seed}")
        with files.owned(tmp_path / "runs" / f"seed_{seed}"):  # nobody is left who trains there
            pass


@pytest.mark.slow
def test_the_end_of_a_process_does_not_look_through_all_objects():
    program = "import atexit, gc; atexit.register(lambda: print(gc.get_freeze_count() > 0))"
    for call, frozen in (("", "False"), ("; from agents.training.seeds import _end_quickly; _end_quickly()", "True")):
        ended = subprocess.run([sys.executable, "-c", program + call], cwd=ROOT, capture_output=True, text=True)
        assert ended.stdout.strip() == frozen


def test_seeds_that_had_not_begun_are_gone_on_with(tmp_path, monkeypatch):
    given = []
    monkeypatch.setattr(seeds, "_run", lambda folders, *_: given.extend(folders))
    train(small(tmp_path / "seed_0"))
    with pytest.raises(ValueError, match="all its runs are finished"):
        resume_seeds(tmp_path)
    (tmp_path / "seed_1").mkdir()
    write_config(tmp_path / "seed_1", checked_config(small(None, seed=1)))
    resume_seeds(tmp_path)
    assert given == [tmp_path / "seed_1"]


def test_a_folder_without_runs_is_refused(tmp_path):
    with pytest.raises(ValueError, match="neither a run nor a folder of runs"):
        resume_seeds(tmp_path)


def test_what_all_seeds_share_is_refused_before_anything_is_written(tmp_path):
    for changes, given, message in (
        ({}, 0, "seeds = 0"),
        ({"hyperparams": {**PPO, "gamma": 2.0}}, 2, "gamma = 2.0"),
        ({"hyperparams": {**PPO, "n_envs": 1, "n_steps": 1}}, 2, "not allowed"),
    ):
        with pytest.raises(ValueError, match=message):
            train_seeds(small(tmp_path / "runs", **changes), given)
    assert not (tmp_path / "runs").exists()


def test_every_seed_is_written_down_before_the_first_begins(tmp_path, monkeypatch):
    given = []
    monkeypatch.setattr(seeds, "_run", lambda folders, *_: given.extend(folders))
    parent = train_seeds(small(tmp_path / "runs", seed=3), 2)
    assert given == [parent / "seed_3", parent / "seed_4"]
    assert [read_config(folder)["seed"] for folder in given] == [3, 4]


def test_two_processes_do_not_go_on_with_the_same_seeds(tmp_path):
    (tmp_path / "seed_0").mkdir()
    write_config(tmp_path / "seed_0", checked_config(small(None)))
    with files.owned(tmp_path), pytest.raises(BlockingIOError, match="in use by process"):
        resume_seeds(tmp_path)


def test_neighbouring_seeds_meet_the_same_rigs_in_all_but_one_environment():
    """Whatever the agents do: what environment i of seed s draws next is what environment i - 1 of seed s + 1 draws."""
    random = np.random.default_rng(0)
    drawn = []
    for seed in (0, 1):
        env = make_environment("DrillRig-v0", 6, seed, {"duration": 3.0})
        env.reset()
        for _ in range(70):
            env.step(random.uniform(-1.0, 1.0, (6, 1)).astype(np.float32))
        drawn.append(batch_of(env)._generators.states)
    np.testing.assert_array_equal(drawn[0][1:], drawn[1][:-1])
    assert (drawn[0] != drawn[1]).all(axis=1).all()


def weights(folder):
    with zipfile.ZipFile(folder / MODEL) as archive:
        return torch.load(io.BytesIO(archive.read("policy.pth")))


def same_weights(one, other):
    ours, theirs = weights(one), weights(other)
    return ours.keys() == theirs.keys() and all(torch.equal(ours[name], theirs[name]) for name in ours)


@pytest.mark.slow
def test_each_seed_ends_with_the_bits_of_its_training_alone(tmp_path):
    train_seeds(small(tmp_path / "one"), 2)
    train_seeds(small(tmp_path / "two"), 2, Local(2))
    train(small(tmp_path / "alone", seed=1))
    for folder in ("one", "two"):
        assert same_weights(tmp_path / folder / "seed_1", tmp_path / "alone")
    assert not same_weights(tmp_path / "one" / "seed_0", tmp_path / "alone")


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_trainings_on_ray_end_with_the_same_bits_also_where_a_worker_is_killed(tmp_path):
    """Its training goes on from the checkpoint, by another worker."""
    pytest.importorskip("ray")
    train_seeds(small(tmp_path / "here", n_timesteps=4096, save_freq=256), 2)
    begun, killed = tmp_path / "ray" / "seed_1" / CHECKPOINT, []

    def kill():
        while not begun.is_file():
            time.sleep(0.02)
        killed.append(int((begun.parent / files.OWNER).read_text()))
        os.kill(killed[0], signal.SIGKILL)

    threading.Thread(target=kill, daemon=True).start()
    with engine_at("ray", 2) as engine:
        train_seeds(small(tmp_path / "ray", n_timesteps=4096, save_freq=256), 2, engine)
    assert killed
    for seed in ("seed_0", "seed_1"):
        assert same_weights(tmp_path / "ray" / seed, tmp_path / "here" / seed)


def test_a_training_that_fails_leaves_the_others_alone(tmp_path, capsys):
    """The second begins with a checkpoint that is none."""
    for seed in (0, 1):
        (tmp_path / f"seed_{seed}").mkdir()
        write_config(tmp_path / f"seed_{seed}", checked_config(small(None, seed=seed)))
    (tmp_path / "seed_0" / CHECKPOINT).write_bytes(b"no checkpoint")

    class Here(Local):
        def outcomes(self, work, pieces, *, apart=False, meanwhile=None):
            assert apart
            return super().outcomes(work, pieces)

    with pytest.raises(Failed, match="training failed for seed_0; what it said is above"):
        resume_seeds(tmp_path, Here(), progress=False)
    assert f"{tmp_path / 'seed_0'}: error: " in capsys.readouterr().err
    assert is_finished(tmp_path / "seed_1")


def test_a_machine_that_does_not_see_the_folder_says_so(tmp_path):
    with pytest.raises(Failed, match="does not see it; trainings need a folder that all machines of a cluster share"):
        seeds._train_one(1, tmp_path / "seed_0")


def test_a_run_that_another_machine_goes_on_with_names_both(tmp_path, monkeypatch):
    write_config(tmp_path, {**checked_config(small(None)), "provenance": {"machine": "one"}})
    monkeypatch.setattr(seeds, "provenance", lambda: {"machine": "other"})
    for _ in range(2):
        seeds._write_machine(tmp_path)
    assert read_config(tmp_path)["provenance"] == {"machine": "one", "also_on": ["other"]}
