"""The command line of evaluation: who competes, what is refused, and how failures end."""

import subprocess
import sys
from pathlib import Path

import pytest

import baselines
from agents.policy.run_folder import shipped
from drillrig_env.cli import evaluate as command
from drillrig_env.evaluation.contestants import contestant_of, find_contestants
from drillrig_env.evaluation.store import read
from drillrig_env.evaluation.suites import suite
from drillrig_env.policy import find_policy
from drillrig_env.rig import Rig
from tests.rigs import STEADY_AND_WINDOW, TWO_WINDOWS

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


def test_an_output_that_cannot_be_written_is_found_out_before_any_policy_runs(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").touch()
    monkeypatch.setattr("drillrig_env.evaluation.pieces.run", None)
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


def test_policies_meet_the_environments_own_rigs_unless_suites_are_named(tmp_path):
    few = ["constant", "--rigs", "1", "--no-pictures", "--output"]
    assert evaluate(*few, tmp_path / "own", "--env", "DrillRigUnknown-v0") == 0
    assert list(read(tmp_path / "own").scores) == ["unknown", "unknown_hard"]
    assert evaluate(*few, tmp_path / "named", "--env", "DrillRigUnknown-v0", "--suite", "default") == 0
    assert list(read(tmp_path / "named").scores) == ["default"]


def test_without_a_terminal_progress_is_a_line_a_policy(tmp_path, capsys):
    evaluate("constant", "jump_ease", *FEW, "--output", tmp_path)
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("default: ")]
    assert [line.split(" done in ")[0] for line in lines] == ["default: constant", "default: jump_ease"]


def test_a_baseline_is_made_for_the_suites_slew_limit():
    contestant = contestant_of(find_policy("jump_ease"), "DrillRig-v0", "jump_ease")
    made = [contestant.members[""](suite(name, 1)) for name in ("default", "degraded")]
    assert [policy.slew_limit for policy in made] == [2.0, 1.0]


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
    assert "  python eval.py --suite default --details" in done.stdout
    assert "drillrig evaluate" not in done.stdout


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (TWO_WINDOWS, "lets the drive of this rig run away"),
        ({"k_p": 0.0, "k_i": 30.0, "K_E": 0.0}, "lets the drive of this rig run away"),
        (STEADY_AND_WINDOW, "critical_slope: this rig is stable for"),
    ],
)
def test_a_rig_whose_drive_shakes_by_itself_is_refused_before_anything_runs(change, said, tmp_path, capsys):
    Rig(**change).to_toml(tmp_path / "rig.toml")
    with pytest.raises(SystemExit) as end:
        command.main(["constant", *FEW, "--rig", str(tmp_path / "rig.toml"), "--output", str(tmp_path / "results")])
    assert end.value.code == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "results").exists()
