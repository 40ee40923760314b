"""The tutorial: its commands exist, its outputs are theirs, and in the long tests the way itself."""

import importlib
import re

import numpy as np
import pytest

from benchmarks.tutorial import PAGE, ROOT, commands_of, main, renewed, run_in
from drillrig_env.calibrate import command as calibrate
from drillrig_env.cli import COMMANDS, evaluate
from drillrig_env.command_line import Failed
from drillrig_env.evaluation.store import read

TEXT = PAGE.read_text(encoding="utf-8")
LINES = [words for block in re.findall(r"```sh\n(.*?)```", TEXT, re.DOTALL) for words in commands_of(block)]


def help_of(words, capsys):
    """What a command says of itself, and the words behind its name."""
    if words[0] == "drillrig":
        name, rest = COMMANDS[words[1]][0], words[2:]
    else:
        assert words[0] == "python"
        name, rest = (words[2], words[3:]) if words[1] == "-m" else (words[1].removesuffix(".py"), words[2:])
    with pytest.raises(SystemExit) as end:
        raise SystemExit(importlib.import_module(name).main(["--help"]))
    assert end.value.code == 0
    return capsys.readouterr().out, rest


@pytest.mark.parametrize("words", LINES, ids=" ".join)
def test_a_command_of_the_tutorial_has_these_flags(words, capsys):
    told, rest = help_of(words, capsys)
    for word in rest:
        assert not word.startswith("--") or re.search(rf"{word}\b", told), word
        assert not word.startswith("docs/") or (ROOT / word).is_file(), word


def test_every_block_of_commands_has_what_it_printed():
    blocks = re.findall(r"```sh\n.*?```\n\n```text\n(.*?)\n```", TEXT, re.DOTALL)
    assert len(blocks) == TEXT.count("```sh") == TEXT.count("```text")
    assert all(block.strip() for block in blocks)
    assert re.search(r"^Run by `python -m benchmarks.tutorial` in \d+ minutes: \d{4}-\d\d-\d\d, ", TEXT, re.MULTILINE)


def test_outputs_take_the_place_of_those_before():
    page = "A.\n\n```sh\na b \\\n  c  # why\nd 'e f'\n```\n\n```text\nold\n```\n\nB.\n\n```sh\nnot run\n```\n"
    said = renewed(page, lambda words: f"{words}\n")
    assert said == page.replace("old", "['a', 'b', 'c']\n['d', 'e f']")


def test_how_a_record_was_read_is_told_once():
    block = "```sh\na\n```\n\n```text\n```\n"
    said = renewed(f"{block}\n{block}", lambda _: "docs/run.csv: read\n1")
    assert said.count("docs/run.csv: read") == 1
    assert said.count("\n1\n```") == 2


def test_shares_of_several_evaluations_stand_side_by_side(tmp_path, capsys):
    for name, policies in (("one", ["constant", "z_torque"]), ("two", ["z_torque"])):
        words = [*policies, "--suite", "default", "--rigs", "8", "--no-pictures", "--output", str(tmp_path / name)]
        assert evaluate.main(words) == 0
    capsys.readouterr()
    assert main(["--shares", str(tmp_path / "one"), str(tmp_path / "two")]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "| policy | one | two |"
    assert re.fullmatch(r"\| constant \| [01]\.\d{3} \([01]\.\d\d to [01]\.\d\d\) \| \|", said[2])
    assert said[3].split(" | ")[1] == said[3].split(" | ")[2].removesuffix(" |")
    with pytest.raises(SystemExit):
        main(["--shares", str(tmp_path)])
    assert str(tmp_path) in capsys.readouterr().err


def test_a_command_that_fails_leaves_the_page(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("```sh\ndrillrig simulate --duration 0\n```\n\n```text\nold\n```\n\nRun by me.\n", encoding="utf-8")
    before = page.read_bytes()
    assert main(["--page", str(page)]) == 1
    assert page.read_bytes() == before
    with pytest.raises(Failed, match=r"drillrig simulate --duration 0 ended with 2: .*'0' is not allowed"):
        run_in(tmp_path, ["drillrig", "simulate", "--duration", "0"])


def test_the_page_is_written_with_machine_and_date(tmp_path, capsys):
    page = tmp_path / "page.md"
    page.write_text("```sh\ndrillrig --version\n```\n\n```text\n```\n\nRun by\nme.\n", encoding="utf-8")
    assert main(["--page", str(page)]) == 0
    assert re.fullmatch(
        r"```sh\ndrillrig --version\n```\n\n```text\ndrillrig [\d.]+\n```\n\nRun by `python [^`]*` in 0 minutes: .*\n?",
        page.read_text(encoding="utf-8"),
        re.DOTALL,
    )


@pytest.mark.slow
def test_the_way_from_a_log_to_the_true_rig(tmp_path, monkeypatch):
    records = [str(ROOT / "docs" / "twin" / f"{name}.csv") for name in ("steps", "sweep", "stick_slip")]
    truth = str(ROOT / "docs" / "twin" / "truth.toml")
    monkeypatch.chdir(tmp_path)
    known = ["J_1=0.041", "k_p=2.2", "k_i=1.4"]
    assert calibrate.main([*records, "--fix", *known, "--starts", "8", "--output", "my_rig"]) == 0
    words = ["constant", "z_torque", "lqg", "--rig", "my_rig", "--suite", "default", "--rigs", "320", "--no-pictures"]
    assert evaluate.main([*words, "--output", "judged"]) == 0
    assert evaluate.main([*words, "--judged-on", truth, "--output", "true"]) == 0
    judged, true = (read(tmp_path / name).scores["default"] for name in ("judged", "true"))
    for policy in judged:  # the same seeds: the same targets, loads and starts
        assert np.mean(judged[policy]["mitigated"]) == pytest.approx(np.mean(true[policy]["mitigated"]), abs=0.05)
    assert np.mean(true["constant"]["mitigated"]) < 0.6
    assert np.mean(true["lqg"]["mitigated"]) > 0.95
