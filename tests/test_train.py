"""The command line of training: flags from the fields of a training, refusals in a sentence, exit codes."""

import signal
from dataclasses import fields
from pathlib import Path

import pytest

import train as command
from agents.policy.run_folder import load_policy, read_config
from agents.training.progress import ShowProgress
from agents.training.settings import Training
from drillrig_env.rig import Rig

SMALL = [
    "-params",
    "n_envs:8",
    "n_steps:16",
    "batch_size:64",
    "n_epochs:1",
    "imitation:null",
    "--env-kwargs",
    "duration:3.0",
]
SHORT = ["-n", "256", "--eval-freq", "-1", "--no-tensorboard", "--no-progress", *SMALL]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    earlier = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield tmp_path
    signal.signal(signal.SIGINT, earlier)


def refused(capsys, *arguments):
    with pytest.raises(SystemExit) as end:
        command.main(list(arguments))
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith("python train.py: error: ")
    assert said.count("\n") == 2
    return said


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("ppo -params gamma", "gamma:0.98"),
        ("-params n_steps:-5", "n_steps = -5 is not allowed; allowed: whole, >= 1"),
        ("-params batch_size:0", "batch_size = 0 is not allowed"),
        ("-params batch_size:abc", "batch_size = 'abc' is not a number"),
        ("-params gamma:1.5", "gamma = 1.5 is not allowed; allowed: >= 0 and <= 1"),
        ("-params gamma:[", "gamma:[: not plain YAML: line 1: "),
        ("-params gamma:!!python/name:os.system", "could not determine a constructor for the tag"),
        ("-params policy:Mlp", "policy 'Mlp' is not known"),
        (
            "-params learning_rate:lin_-1",
            "learning_rate = lin_-1 is not allowed; allowed: > 0 and <= 1, or lin_<number>",
        ),
        ("--env-kwargs rig:5", "rig = 5 is not allowed; allowed: a Rig, a dictionary"),
        ("--env-kwargs rig:rig.toml", "there is no file rig.toml"),
        ("--env-kwargs nois:2", "did you mean noise"),
        ("--env Drill-v0", "did you mean DrillRig-v0"),
        ("--conf-file none.yml", "there is no file of hyperparameters none.yml"),
        ("-n abc", "argument -n/--n-timesteps: 'abc' is not allowed; allowed: whole, >= 1 steps"),
        ("-n inf", "'inf' is not allowed"),
        ("--threads -1", "argument --threads: '-1' is not allowed; allowed: whole, >= 1"),
        ("--seed -1", "argument --seed: '-1' is not allowed; allowed: whole, >= 0"),
        ("--seed 500000000", "allowed: whole, >= 0 and <= 499999999"),
        ("--seeds 0", "argument --seeds: '0' is not allowed"),
        ("--rig mine.toml", "argument --rig: rig: there is no file mine.toml"),
        ("--sed 3", "unknown argument --sed; did you mean --seed?"),
        ("ppo --algo sac", "--algo sac and ppo contradict each other"),
        ("pppo", "'pppo' is not known; did you mean ppo?"),
    ],
)
def test_mistakes_are_explained_before_anything_is_written(arguments, message, capsys, elsewhere):
    assert message in refused(capsys, *arguments.split())
    assert not list(elsewhere.iterdir())


def test_a_file_of_hyperparameters_that_cannot_be_read_is_named(capsys, elsewhere):
    for content, message in (
        (b"DrillRig-v0: {gamma: [", "mine.yml: not plain YAML: line 1: "),
        (b"DrillRig-v0: !!python/object/apply:os.system [ls]", "mine.yml: not plain YAML: line 1: could not determine"),
        (b"- 1", "mine.yml: allowed: a table of hyperparameters for each environment"),
        (b"DrillRig-v0: {gamma: 0.9}", "mine.yml: the hyperparameters for 'DrillRig-v0' lack policy"),
        (b"\xff\xfe\x00", "mine.yml: not a text"),
    ):
        (elsewhere / "mine.yml").write_bytes(content)
        assert message in refused(capsys, "-conf", "mine.yml")


def test_every_field_of_a_training_has_a_flag_and_its_words_are_in_the_help():
    told = " ".join(command.argument_parser("train").format_help().split())
    assert all(item.metadata["meaning"] for item in fields(Training))
    for item in fields(Training):
        assert item.metadata["meaning"] in told
    known = {action.dest for action in command.argument_parser("train")._actions}
    assert {item.name for item in fields(Training)} <= known


def test_flags_reach_the_training_and_a_rig_file_goes_into_its_config(capsys, elsewhere):
    Rig(k_2=0.5).to_toml("rig.toml")
    assert command.main(["--algo", "ppo", "--seed", "3", "-f", "mine", *SHORT, "rig:rig.toml"]) == 0
    assert command.main(["--rig", "rig.toml", "-f", "mine", *SHORT]) == 0
    assert Rig.of(read_config("mine/ppo_2")["env_kwargs"]["rig"]) == Rig(k_2=0.5)
    assert capsys.readouterr().out == f"run folder: {Path('mine/ppo_1')}\nrun folder: {Path('mine/ppo_2')}\n"
    config = read_config("mine/ppo_1")
    assert (config["seed"], config["hyperparameters"]["n_timesteps"]) == (3, 256)
    assert Rig.of(config["env_kwargs"]["rig"]) == Rig(k_2=0.5)


def test_ctrl_c_ends_with_130_and_resume_goes_on_to_the_end(capsys, monkeypatch):
    with monkeypatch.context() as pressed:
        pressed.setattr(ShowProgress, "_on_rollout_end", lambda _: signal.raise_signal(signal.SIGINT))
        assert command.main(["--run-folder", "run", *SHORT]) == 130
    said = capsys.readouterr().err
    assert said.startswith("stopped by Ctrl-C; run keeps the model of 128 of 256 steps; to go on: ")
    assert "without --seed, --n-timesteps;" in refused(capsys, "--resume", "run", "--seed", "0", "-n", "512")
    assert command.main(["--resume", "run", "--no-progress", "--jobs", "1", "--threads", "1"]) == 0
    assert load_policy("run").model.num_timesteps == 256
    assert "the run is finished" in refused(capsys, "--resume", "run")


def test_sigterm_ends_with_143(capsys, monkeypatch):
    monkeypatch.setattr(ShowProgress, "_on_rollout_end", lambda _: signal.raise_signal(signal.SIGTERM))
    assert command.main(["--run-folder", "run", *SHORT]) == 143
    assert capsys.readouterr().err.startswith("stopped by SIGTERM; run keeps the model of 128 of 256 steps")


def test_a_folder_that_cannot_be_written_ends_with_1(capsys, elsewhere):
    (elsewhere / "file").touch()
    assert command.main(["-f", "file", *SHORT]) == 1
    assert capsys.readouterr().err.startswith("error: file cannot be written")
