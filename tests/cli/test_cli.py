import subprocess
import sys

import pytest

from drillrig_env import Rig, __version__
from drillrig_env.cli import COMMANDS, main


def run(*words, cwd=None):
    return subprocess.run(
        [sys.executable, "-c", "from drillrig_env.cli import main; raise SystemExit(main())", *words],
        capture_output=True, text=True, cwd=cwd, check=False,
    )  # fmt: skip


def test_help_teaches_every_command_and_a_first_look(capsys):
    with pytest.raises(SystemExit) as end:
        main(["--help"])
    assert end.value.code == 0
    text = capsys.readouterr().out
    for name, (_, about) in COMMANDS.items():
        assert f"  {name}" in text
        assert about in text
    assert "drillrig info --write my_rig.toml" in text
    assert "Exit codes: 0 done" in text


def test_no_words_at_all_help_as_well(capsys):
    assert main([]) == 0
    assert "commands:" in capsys.readouterr().out


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"drillrig {__version__}\n"


def test_an_unknown_command_ends_with_the_closest_known_one(capsys):
    with pytest.raises(SystemExit) as end:
        main(["simulte", "--speed-reference", "2"])
    assert end.value.code == 2
    assert capsys.readouterr().err.startswith("drillrig: error: command 'simulte' is not known; did you mean simulate?")


@pytest.mark.parametrize("name", [name for name in COMMANDS if name != "train"])
def test_every_command_explains_itself_under_its_own_name(name, capsys):
    with pytest.raises(SystemExit) as end:
        main([name, "--help"])
    assert end.value.code == 0
    assert capsys.readouterr().out.startswith(f"usage: drillrig {name} ")


@pytest.mark.parametrize("name", ["info", "simulate", "figures", "animate", "measured"])
def test_every_command_refuses_in_one_sentence_a_rig_that_is_wrong(name, tmp_path, capsys):
    (tmp_path / "rig.toml").write_text('[rig]\nbase = "chapter"\nJ_1 = "0.3"\n')
    needed = {"animate": ["--output", "a.gif"], "measured": ["a.csv", "--speed-reference", "2", "--normal-force", "1"]}
    with pytest.raises(SystemExit) as end:
        main([name, *needed.get(name, []), "--rig", str(tmp_path / "rig.toml")])
    assert end.value.code == 2
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith(f"drillrig {name}: error: argument --rig: ")
    assert "J_1 = '0.3' is text; write 0.3, without quotes" in first
    assert second == f"help: drillrig {name} --help"


def test_a_flag_cut_short_or_misspelt_is_refused_with_the_closest(capsys):
    with pytest.raises(SystemExit):
        main(["info", "--normal-forc", "3"])
    assert "unknown argument --normal-forc; did you mean --normal-force?" in capsys.readouterr().err


@pytest.mark.slow
def test_train_runs_the_clones_command(tmp_path):
    done = run("train", "--help", cwd=tmp_path)
    assert done.returncode == 0
    assert "--n-timesteps" in done.stdout


def test_train_without_a_clone_says_how_to_get_one(monkeypatch, capsys):
    monkeypatch.setattr("drillrig_env.cli.train._clone", lambda: None)
    with pytest.raises(SystemExit) as end:
        main(["train", "ppo"])
    assert end.value.code == 2
    assert "in a clone of the project, and there is none here" in capsys.readouterr().err
    with pytest.raises(SystemExit) as end:
        main(["train", "--help"])
    assert end.value.code == 0
    assert "pip install --editable '.[agents]'" in capsys.readouterr().out


def test_rig_files_of_ones_own_go_through_every_step(tmp_path, capsys):
    assert main(["info", "--write", str(tmp_path / "rig.toml")]) == 0
    text = (tmp_path / "rig.toml").read_text()
    (tmp_path / "rig.toml").write_text(text.replace("k_1 = 1.1175", "k_1 = 0.9"))
    assert Rig.from_toml(tmp_path / "rig.toml") == Rig(k_1=0.9)
    capsys.readouterr()
    assert main(["info", "--rig", str(tmp_path / "rig.toml")]) == 0
    assert "k_1      0.9" in capsys.readouterr().out
