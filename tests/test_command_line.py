import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from drillrig_env.command_line import Failed, Parser, Terminated, command, sentence_of

STOPPED = """
import signal, sys
from drillrig_env.command_line import command

@command
def main():
    try:
        signal.raise_signal(getattr(signal, sys.argv[1]))
    except KeyboardInterrupt as stop:
        stop.add_note("two of three are kept")
        raise

raise SystemExit(main())
"""


@pytest.fixture
def parser():
    made = Parser(prog="python eval.py")
    made.add_argument("--rigs", type=int)
    made.add_argument("--suite", choices=["default", "wide"])
    return made


def test_an_error_is_a_sentence_without_the_usage_above_it(parser, capsys):
    with pytest.raises(SystemExit) as end:
        parser.parse_args(["--rigs", "many"])
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith("python eval.py: error: argument --rigs: invalid int value: 'many'\n")
    assert "usage" not in said
    assert "--help" in said


def test_a_flag_cut_short_is_not_taken_for_another(parser, capsys):
    with pytest.raises(SystemExit):
        parser.parse_args(["--rig", "3"])
    assert "unknown argument --rig; did you mean --rigs?" in capsys.readouterr().err
    assert parser.parse_args(["--rigs", "3"]).rigs == 3


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--suite", "defualt"], "argument --suite: 'defualt' is not known; did you mean default? allowed: default"),
    ],
)
def test_impossible_values_are_refused_with_what_is_allowed(parser, arguments, words, capsys):
    with pytest.raises(SystemExit) as end:
        parser.parse_args(arguments)
    assert end.value.code == 2
    assert words in capsys.readouterr().err


def test_possible_values_are_taken(parser):
    found = parser.parse_args(["--suite", "wide", "--rigs", "2"])
    assert (found.suite, found.rigs) == ("wide", 2)


@pytest.mark.parametrize(
    ("stop", "code", "line"),
    [(KeyboardInterrupt(), 130, "stopped by Ctrl-C\n"), (Terminated(), 143, "stopped by SIGTERM\n")],
)
def test_a_stop_is_one_line_and_a_code(stop, code, line, capsys):
    def main():
        raise stop

    assert command(main)() == code
    assert capsys.readouterr().err == line


def test_a_file_that_fails_is_one_line_and_a_code(capsys):
    def main(path):
        path.read_text()

    assert command(main)(Path("/nowhere/at all")) == 1
    assert capsys.readouterr().err.startswith("error: ")
    assert command(lambda: None)() == 0

    def fails():
        failure = Failed("seed_3 failed")
        failure.add_note("two of three are kept")
        raise failure

    assert command(fails)() == 1
    assert capsys.readouterr().err == "error: seed_3 failed; two of three are kept\n"
    assert command(lambda: 1)() == 1


@pytest.mark.parametrize(
    ("failure", "said"),
    [(FloatingPointError("nan rad"), "nan rad"), (MemoryError("728 TiB"), "728 TiB"), (MemoryError(), "MemoryError")],
)
def test_what_cannot_be_computed_is_one_line_and_a_code(failure, said, capsys):
    def main():
        raise failure

    assert command(main)() == 1
    assert capsys.readouterr().err == f"error: {said}\n"


def test_handlers_are_given_back():
    earlier = signal.getsignal(signal.SIGTERM)
    assert command(lambda: 0)() == 0
    assert signal.getsignal(signal.SIGTERM) is earlier


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals between processes")
@pytest.mark.parametrize(("name", "code", "by"), [("SIGINT", 130, "Ctrl-C"), ("SIGTERM", 143, "SIGTERM")])
def test_a_process_that_is_stopped_ends_with_its_note_and_code(name, code, by):
    script = f"import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n{STOPPED}"
    ended = subprocess.run([sys.executable, "-c", script, name], capture_output=True, text=True)
    assert ended.returncode == code
    assert ended.stderr == f"stopped by {by}; two of three are kept\n"


def test_a_file_that_cannot_be_read_is_named_first(tmp_path, parser, capsys):
    with pytest.raises(FileNotFoundError) as missing:
        (tmp_path / "my.csv").read_text()
    assert sentence_of(missing.value) == f"{tmp_path / 'my.csv'}: no such file or directory"
    assert sentence_of(OSError("no space is left")) == "no space is left"
    assert sentence_of(MemoryError()) == "MemoryError"
    with pytest.raises(SystemExit):
        parser.error(missing.value)
    assert capsys.readouterr().err.startswith(f"python eval.py: error: {tmp_path / 'my.csv'}: no such file")

    @command
    def main():
        raise missing.value

    assert main() == 1
    assert "Errno" not in capsys.readouterr().err
