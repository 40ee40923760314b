"""Run the commands of docs/tutorial.md, as they stand there, and write what they print into the page.

    python -m benchmarks.tutorial                 # about a quarter of an hour of two cores
    python -m benchmarks.tutorial --page PAGE     # of another page
    python -m benchmarks.tutorial --shares DIR DIR ...   # only print who mitigated what in several evaluations

Every block of commands is run in one new folder, in which `docs`, `train.py` and `eval.py` are those of the clone; the
block of text behind it becomes what they print, without what is told on the way and without how a record was read where
that was told before. The line that begins with "Run by"
becomes when and on what machine. A command that fails ends it, and the page stays as it was.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy.typing as npt

from benchmarks.measure import note
from drillrig_env.command_line import Failed, Parser, command
from drillrig_env.evaluation.provenance import in_words, provenance
from drillrig_env.evaluation.store import read
from drillrig_env.evaluation.tables import MAIN
from drillrig_env.files import check_writable_file, write_text
from drillrig_env.markdown import table

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "tutorial.md"

_LENT = ("docs", "train.py", "eval.py")
_BLOCK = re.compile(r"```sh\n(?P<commands>.*?)```\n\n```text\n.*?```", re.DOTALL)
_RUN_BY = re.compile(r"^Run by\b.*?(?=\n\n|\Z)", re.MULTILINE | re.DOTALL)
_NOTES = re.compile(r"\S+\.csv: ")
_WIDTH = 110


def commands_of(block: str) -> list[list[str]]:
    """The commands of a block, a list of words each; lines that end with a backslash go on."""
    lines = block.replace("\\\n", " ").splitlines()
    return [words for words in (shlex.split(line, comments=True) for line in lines) if words]


def renewed(text: str, printed: Callable[[Sequence[str]], str]) -> str:
    """The page with what `printed` returns for each command in the blocks of text behind blocks of commands."""
    told: set[str] = set()

    def block(found: re.Match[str]) -> str:
        lines = "\n".join(printed(words).strip("\n") for words in commands_of(found["commands"])).splitlines()
        said = "\n".join(_wrapped(line) for line in lines if line not in told).strip("\n")
        told.update(line for line in lines if _NOTES.match(line))
        return f"```sh\n{found['commands']}```\n\n```text\n{said}\n```"

    return _BLOCK.sub(block, text)


def shares(folders: Sequence[Path]) -> str:
    """A table of the share of episodes that each policy mitigated in the suite `default` of several evaluations."""
    found = [read(folder) for folder in folders]
    names = list(dict.fromkeys(name for results in found for name in results.scores["default"]))
    rows = []
    for name in names:
        cells = [results.scores["default"].get(name) for results in found]
        rows.append([name, *("" if scores is None else _share(scores) for scores in cells)])
    return table(["policy", *(folder.name for folder in folders)], rows)


def _share(scores: Mapping[str, npt.NDArray[Any]]) -> str:
    estimate = MAIN.columns[0].estimate(scores)
    return f"{estimate.value:.3f} ({estimate.low:.2f} to {estimate.high:.2f})"


def run_in(folder: Path, words: Sequence[str]) -> str:
    """What a command prints that is run in a folder, in lines that a page can hold. `Failed` where it does."""
    note(shlex.join(words))
    python = [sys.executable] if words[0] == "python" else [sys.executable, "-m", "drillrig_env.cli"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "100"}
    done = subprocess.run([*python, *words[1:]], cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise Failed(f"{shlex.join(words)} ended with {done.returncode}: {done.stderr.strip()}")
    lines = done.stdout.replace(f"{folder.resolve()}{os.sep}", "").splitlines()
    return "\n".join(line.rstrip() for line in lines)


def _wrapped(line: str) -> str:
    if len(line) <= _WIDTH or line.startswith("|"):
        return line
    return "\n".join(textwrap.wrap(line, _WIDTH, subsequent_indent="    ", break_on_hyphens=False))


@command
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the page's commands and write the page."""
    parser = Parser(prog="python -m benchmarks.tutorial", description=__doc__)
    parser.add_argument("--page", type=Path, default=PAGE, help="default: docs/tutorial.md")
    parser.add_argument("--shares", nargs="+", type=Path, metavar="DIR", help="results of evaluations to compare")
    chosen = parser.parse_args(arguments)
    if chosen.shares:
        try:
            print(shares(chosen.shares))
        except (ValueError, OSError, KeyError) as error:
            parser.error(error)
        return 0
    check_writable_file(chosen.page)
    text, begin = chosen.page.read_text(encoding="utf-8"), time.monotonic()
    with TemporaryDirectory() as made:
        folder = Path(made)
        for name in _LENT:
            (folder / name).symlink_to(ROOT / name)
        text = renewed(text, lambda words: run_in(folder, words))
    minutes = (time.monotonic() - begin) / 60.0
    told = f"Run by `python -m benchmarks.tutorial` in {minutes:.0f} minutes: {in_words(provenance())}."
    write_text(chosen.page, _RUN_BY.sub("\n".join(textwrap.wrap(told, 120)), text))
    print(chosen.page)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
