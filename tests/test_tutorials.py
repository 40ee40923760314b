"""The tutorials' commands run as they stand, and print what the pages say."""

import re
import shlex
from pathlib import Path

import pytest

from drillrig_env.cli import main

DOCS = Path(__file__).parents[1] / "docs"
PAGES = ["tutorials/first_run.md", "tutorials/own_controller.md", "tutorials/own_rig.md"]
FILES = {"my_controller.py": ("python", "class GiveWay"), "my_rig.toml": ("toml", 'base = "chapter"')}
"""What a reader is told to save, by the language of its block and a piece of it."""


def blocks(text):
    """Language and content of every block of a page, in order."""
    return re.findall(r"```(\w+)\n(.*?)```", text, re.DOTALL)


def commands_of(block):
    return [
        words[1:] for line in block.replace("\\\n", " ").splitlines() if (words := shlex.split(line, comments=True))
    ]


def plain(line):
    return " ".join(line.split())


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_commands_print_what_the_page_says(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    printed, compared = "", 0
    for language, content in blocks((DOCS / page).read_text(encoding="utf-8")):
        for name, (kind, piece) in FILES.items():
            if language == kind and piece in content and not Path(name).exists():
                Path(name).write_text(content, encoding="utf-8")
        if language == "sh" and content.startswith("drillrig "):
            for words in commands_of(content):
                assert main(words) == 0
            printed = capsys.readouterr().out
        elif language == "text" and printed:
            lines = {plain(line) for line in printed.splitlines()}
            missing = [line for line in content.splitlines() if plain(line) not in lines]
            assert missing == []
            compared += 1
    assert compared >= 2


def test_commands_are_found_in_blocks():
    text = "```sh\ndrillrig info --rig a.toml \\\n    --x 1  # what\n```\n\n```text\nout\n```\n"
    (language, content), (_, out) = blocks(text)
    assert language == "sh"
    assert commands_of(content) == [["info", "--rig", "a.toml", "--x", "1"]]
    assert plain("  a   b ") == "a b"
    assert out == "out\n"
