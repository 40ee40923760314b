"""The command line: who competes, what it leaves behind, what goes on after a cut, and how failures end."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import baselines
from agents.policy.run_folder import shipped
from drillrig_env.cli import evaluate as command
from drillrig_env.command_line import Terminated
from drillrig_env.evaluation.contestants import contestant_of, find_contestants
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.store import read
from drillrig_env.evaluation.suites import suite
from drillrig_env.files import owned
from drillrig_env.policy import find_policy
from drillrig_env.rig import Rig

FEW = ["--suite", "default", "--rigs", "8", "--no-pictures"]


@pytest.fixture
def controller(tmp_path):
    path = tmp_path / "my_controller.py"
    path.write_text(command.EXAMPLE + OTHERS)
    return path


OTHERS = '''

class Plain:
    """No baseline: made without arguments."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), 1), np.float32), None


class Breaks(Plain):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        raise ZeroDivisionError("torque over nothing")


import numpy as np
'''


def evaluate(*arguments):
    return command.main([*map(str, arguments)], prog="python eval.py")


def test_a_controller_of_ones_own_competes(controller, tmp_path, capsys):
    output = tmp_path / "results"
    assert (
        evaluate("constant", f"{controller}:MyPolicy", f"{controller}:Plain", *FEW, "--rigs", 30, "--output", output)
        == 0
    )
    scores = read(output).scores["default"]
    assert list(scores) == ["constant", "MyPolicy", "Plain"]
    assert scores["MyPolicy"]["mitigated"].mean() > scores["constant"]["mitigated"].mean() + 0.2
    assert (scores["Plain"]["cost"] == scores["constant"]["cost"]).all()
    assert "MyPolicy" in capsys.readouterr().out


def test_the_documented_example_has_about_ten_lines_of_code():
    lines = [line for line in command.EXAMPLE.splitlines() if line.strip()]
    assert len(lines) <= 10


def test_failures_are_named_the_others_kept_and_the_status_says_so(controller, tmp_path, capsys):
    output = tmp_path / "results"
    names = [f"{controller}:Breaks", "jump_ease_estimated", "constant"]
    assert evaluate(*names, *FEW, "--env", "DrillRigSurface-v0", "--output", output) == 1
    said = capsys.readouterr().err
    assert "Breaks failed in default: ZeroDivisionError: torque over nothing" in said
    assert "my_controller.py" in said
    assert "jump_ease_estimated failed" in said
    assert read(output).policies == ["constant"]


def test_baselines_that_nobody_named_are_left_out_with_a_reason():
    said = []
    field, failures, _ = find_contestants([], "DrillRigSurface-v0", say=said.append)
    assert not failures
    assert len(field) + len(said) == len(baselines.BASELINES) + len(shipped())
    assert any("jump_ease_estimated is left out" in line and "bit_speed" in line for line in said)
    slow = [name for name, policy in baselines.BASELINES.items() if policy.slow]
    assert all(name not in [one.name for one in field] for name in slow)
    everyone, *_ = find_contestants([], "DrillRig-v0", slow=True, say=said.append)
    assert set(slow) <= {one.name for one in everyone}


def test_resume_goes_on_where_it_was_cut(tmp_path, monkeypatch, capsys):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    names = ["constant", "jump_ease", "--suite", "chapter", "default", "--rigs", "5", "--no-pictures"]
    assert evaluate(*names, "--output", whole) == 0
    ran = []

    def interrupted(policy, one, **arguments):
        ran.append((one.name, type(policy).__name__))
        if len(ran) == 3:
            raise KeyboardInterrupt
        return run(policy, one, **arguments)

    monkeypatch.setattr("drillrig_env.evaluation.contest.run", interrupted)
    assert evaluate(*names, "--output", cut) == 130
    assert f"what was finished is in {cut}; to go on: python eval.py constant" in (said := capsys.readouterr().err)
    assert said.rstrip().endswith("--resume")
    assert evaluate(*names, "--output", cut, "--resume") == 0
    assert ran[2:] == [("default", "Constant"), ("default", "Constant"), ("default", "JumpEase")]
    assert (cut / "results.csv").read_bytes() == (whole / "results.csv").read_bytes()
    found = [json.loads((folder / "results.json").read_text())["estimates"] for folder in (cut, whole)]
    assert found[0] == found[1]


def test_resume_refuses_what_was_made_otherwise(tmp_path, capsys):
    evaluate("constant", *FEW, "--output", tmp_path)
    with pytest.raises(SystemExit):
        evaluate("constant", "--suite", "default", "--rigs", "9", "--output", tmp_path, "--resume")
    assert "rigs was 8, and is 9 now" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        evaluate("constant", *FEW, "--output", tmp_path, "--resume", "--env", "DrillRigSurface-v0")
    assert "env was DrillRig-v0" in capsys.readouterr().err


def test_the_same_command_twice_makes_the_same_files_and_another_one_is_refused(tmp_path, capsys):
    names = ["constant", "jump_ease", *FEW]
    assert evaluate(*names, "--output", tmp_path) == 0
    first = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.suffix in (".csv", ".npz")}
    (tmp_path / "map_default.png").touch()
    assert evaluate(*names, "--output", tmp_path) == 0
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.suffix in (".csv", ".npz")} == first
    assert not (tmp_path / "map_default.png").exists()
    with pytest.raises(SystemExit) as end:
        evaluate("constant", *FEW, "--output", tmp_path)
    assert end.value.code == 2
    assert "holds results of jump_ease, which this command would not make again" in capsys.readouterr().err
    assert read(tmp_path).policies == ["constant", "jump_ease"]
    assert evaluate("constant", *FEW, "--output", tmp_path, "--overwrite") == 0
    assert read(tmp_path).policies == ["constant"]


def test_a_folder_has_one_evaluation_at_a_time(tmp_path, capsys):
    with owned(tmp_path):
        assert evaluate("constant", *FEW, "--output", tmp_path) == 1
    assert f"error: {tmp_path} is in use by" in capsys.readouterr().err
    assert not (tmp_path / "results.json").exists()


def test_an_output_that_cannot_be_written_is_found_out_before_any_policy_runs(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").touch()
    monkeypatch.setattr("drillrig_env.evaluation.contest.run", None)
    assert evaluate("constant", *FEW, "--output", tmp_path / "file" / "results") == 1
    assert "cannot be written" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--suite", "defualt"], "argument --suite: 'defualt' is not known; did you mean default?"),
        (["--rigs", "0"], "argument --rigs: '0' is not allowed; allowed: whole, >= 1"),
        (["--env", "DrillRig-v1"], "did you mean DrillRig-v0?"),
        (["--rig", "nosuch.toml"], "argument --rig: rig: there is no file nosuch.toml"),
        (["--resume", "--overwrite"], "not allowed with argument"),
        (["constnat"], "did you mean constant?"),
        (["nosuch.py:Policy"], "nosuch.py"),
        (["constant", "--reference", "constnat"], "did you mean constant?"),
    ],
)
def test_what_cannot_be_done_is_a_sentence_and_nothing_is_written(arguments, words, tmp_path, capsys):
    with pytest.raises(SystemExit) as end:
        evaluate(*arguments, "--output", tmp_path / "results")
    said = capsys.readouterr().err
    assert end.value.code == 2
    assert said.startswith("python eval.py: error: ")
    assert words in said
    assert "usage:" not in said
    assert list(tmp_path.iterdir()) == []


def test_without_a_terminal_progress_is_a_line_a_policy(tmp_path, capsys):
    evaluate("constant", "jump_ease", *FEW, "--output", tmp_path)
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("default: ")]
    assert [line.split(" done in ")[0] for line in lines] == ["default: constant", "default: jump_ease"]


def test_tables_do_not_need_histories_that_are_damaged(tmp_path, capsys):
    evaluate("constant", *FEW, "--output", tmp_path)
    (tmp_path / "histories.npz").write_bytes(b"PK")
    assert evaluate("--from", tmp_path, "--no-pictures") == 0
    assert "damaged" not in capsys.readouterr().err
    (tmp_path / "results.csv").write_bytes(b"")
    with pytest.raises(SystemExit):
        evaluate("--from", tmp_path, "--no-pictures")
    assert "results.csv is damaged: it has 0 rows, and had 8" in capsys.readouterr().err


@pytest.mark.parametrize(("stop", "code"), [(KeyboardInterrupt, 130), (Terminated, 143)])
def test_a_stop_keeps_what_was_finished(stop, code, tmp_path, monkeypatch, capsys):
    ran = []

    def stopped(policy, one, **arguments):
        ran.append(policy)
        if len(ran) == 2:
            raise stop
        return run(policy, one, **arguments)

    monkeypatch.setattr("drillrig_env.evaluation.contest.run", stopped)
    assert evaluate("constant", "jump_ease", *FEW, "--output", tmp_path, "--overwrite") == code
    said = capsys.readouterr().err
    assert "Traceback" not in said
    assert said.rstrip().endswith("--resume")
    assert "--overwrite" not in said
    assert read(tmp_path).policies == ["constant"]


def test_more_policies_join_what_is_there(tmp_path):
    evaluate("jump_ease", *FEW, "--output", tmp_path)
    before = read(tmp_path).scores["default"]["jump_ease"]["cost"]
    evaluate("constant", "jump_ease", *FEW, "--output", tmp_path, "--resume", "--reference", "jump_ease")
    results = read(tmp_path)
    assert results.policies == ["constant", "jump_ease"]
    assert (results.scores["default"]["jump_ease"]["cost"] == before).all()
    assert "differences" in results.estimates["default"]["constant"]


def test_tables_are_printed_again_without_running(tmp_path, monkeypatch, capsys):
    evaluate("constant", "jump_ease", *FEW, "--output", tmp_path, "--details")
    first = capsys.readouterr().out
    monkeypatch.setattr("drillrig_env.evaluation.contest.run", None)
    assert evaluate("--from", tmp_path, "--no-pictures", "--details") == 0
    assert capsys.readouterr().out.split("results.csv")[0].strip() == first.split("results.csv")[0].strip()
    with pytest.raises(SystemExit):
        evaluate("--from", tmp_path / "nothing")


def test_a_baseline_is_made_for_the_suites_slew_limit():
    contestant = contestant_of(find_policy("jump_ease"), "DrillRig-v0", "jump_ease")
    made = [contestant.members[""](suite(name, 1)) for name in ("default", "degraded")]
    assert [policy.slew_limit for policy in made] == [2.0, 1.0]


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
                hyperparams={"n_envs": 2, "n_steps": 64, "batch_size": 64, "n_epochs": 1},
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
            hyperparams={"n_envs": 2, "n_steps": 64, "batch_size": 64, "n_epochs": 1},
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
    assert evaluate("ppo_surface", *FEW, "--output", tmp_path) == 0
    assert read(tmp_path).config["env"] == "DrillRigSurface-v0"


def test_a_rig_of_ones_own_is_everyones_and_kept_in_the_results(tmp_path, capsys):
    Rig(k_1=0.6).to_toml(tmp_path / "rig.toml")
    own, chapter = tmp_path / "own", tmp_path / "chapter"
    words = ["lqg", *FEW]
    assert evaluate(*words, "--rig", tmp_path / "rig.toml", "--output", own) == 0
    assert "each with k_1 = 0.6 N m/rad" in capsys.readouterr().out
    assert evaluate(*words, "--output", chapter) == 0
    assert read(own).config["rig"]["k_1"] == 0.6
    assert "rig" not in read(chapter).config
    omega_c = read(own).scores["default"]["lqg"]["critical_speed"]
    assert (omega_c != read(chapter).scores["default"]["lqg"]["critical_speed"]).all()
    with pytest.raises(SystemExit):
        evaluate(*words, "--output", own, "--resume")
    assert "rig was " in capsys.readouterr().err


def test_a_policy_is_made_for_the_rig_that_it_meets(tmp_path):
    (contestant,), _, conditions = find_contestants(["lqg"], "DrillRig-v0", rig={"k_1": 0.6})
    assert conditions.rig == Rig(k_1=0.6)
    assert contestant.members[""](suite("default", 2)).rig == Rig(k_1=0.6)


def test_eval_py_in_a_clone_is_the_same_command():
    done = subprocess.run(
        [sys.executable, str(Path(__file__).parents[1] / "eval.py"), "--help"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    assert done.stdout.startswith("usage: python eval.py ")
