"""What an evaluation leaves behind, and the next command into its folder: goes on, makes it again, or is refused."""

import json

import pytest

from drillrig_env.cli import evaluate as command
from drillrig_env.command_line import Terminated
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.store import read
from drillrig_env.files import owned

FEW = ["--suite", "default", "--rigs", "8", "--no-pictures"]


def evaluate(*arguments):
    return command.main([*map(str, arguments)], prog="python eval.py")


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

    monkeypatch.setattr("drillrig_env.evaluation.pieces.run", interrupted)
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

    monkeypatch.setattr("drillrig_env.evaluation.pieces.run", stopped)
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
    monkeypatch.setattr("drillrig_env.evaluation.pieces.run", None)
    assert evaluate("--from", tmp_path, "--no-pictures", "--details") == 0
    assert capsys.readouterr().out.split("results.csv")[0].strip() == first.split("results.csv")[0].strip()
    with pytest.raises(SystemExit):
        evaluate("--from", tmp_path / "nothing")
