"""The command line: who competes, what it leaves behind, what goes on after a cut, and how failures end."""

import json

import pytest

import baselines
import eval as command
from agents.policy.run_folder import shipped
from drillrig_env.evaluation.contestants import contestant_of, find_contestants
from drillrig_env.evaluation.results import read
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.suites import suite
from drillrig_env.policy import find_policy

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
    return command.main([*map(str, arguments)])


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
    names = [f"{controller}:Breaks", "lqgg", f"{controller}:Nobody", "jump_ease_estimated", "constant"]
    assert evaluate(*names, *FEW, "--env", "DrillRigSurface-v0", "--output", output) == 1
    said = capsys.readouterr().err
    assert "Breaks failed in default: ZeroDivisionError: torque over nothing" in said
    assert "my_controller.py" in said
    assert "lqgg failed: ValueError" in said
    assert "has no class 'Nobody'" in said
    assert "jump_ease_estimated failed" in said
    assert read(output).policies == ["constant"]


def test_baselines_that_nobody_named_are_left_out_with_a_reason():
    said = []
    field, failures = find_contestants([], "DrillRigSurface-v0", say=said.append)
    assert not failures
    assert len(field) + len(said) == len(baselines.BASELINES) + len(shipped())
    assert any("jump_ease_estimated is left out" in line and "bit_speed" in line for line in said)
    slow = [name for name, policy in baselines.BASELINES.items() if policy.slow]
    assert all(name not in [one.name for one in field] for name in slow)
    everyone, _ = find_contestants([], "DrillRig-v0", slow=True, say=said.append)
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
    assert "--resume" in capsys.readouterr().out
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


def test_an_unknown_reference_is_refused(tmp_path, capsys):
    with pytest.raises(SystemExit):
        evaluate("constant", *FEW, "--output", tmp_path, "--reference", "constnat")
    assert "did you mean constant" in capsys.readouterr().err


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
    assert contestant.env == {"sensors": "state"}
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
