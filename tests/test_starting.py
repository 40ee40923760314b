"""A stop while a command still imports: a line, a code and no traceback; other programs are left alone."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from drillrig_env import starting

ROOT = Path(__file__).parents[1]
STOPS = "import signal\nsignal.raise_signal(signal.{})\n"


def run(tmp_path, name, *words):
    """Start Python where importing what computes gets a signal."""
    (tmp_path / "numba.py").write_text(STOPS.format(name))
    paths = os.pathsep.join([str(tmp_path), str(ROOT)])
    ready = "import os, signal, sys; signal.signal(signal.SIGINT, signal.SIG_DFL); os.execv(sys.argv[1], sys.argv[1:])"
    return subprocess.run(
        [sys.executable, "-c", ready, sys.executable, *words],
        env={**os.environ, "PYTHONPATH": paths},
        cwd=ROOT,
        capture_output=True,
        text=True,
    )


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals between processes")
@pytest.mark.parametrize(
    "words",
    [
        ["train.py"],
        ["eval.py"],
        ["-m", "drillrig_env.cli", "evaluate"],
        ["-m", "docs.make"],
        ["-m", "baselines.tune", "lqg"],
        ["-m", "agents.export", "ppo"],
        ["-m", "benchmarks.solvers"],
    ],
)
def test_ctrl_c_while_a_command_imports_is_a_line_and_130(words, tmp_path):
    ended = run(tmp_path, "SIGINT", *words)
    assert (ended.returncode, ended.stderr.splitlines()[-1]) == (130, "stopped by Ctrl-C")
    assert "Traceback" not in ended.stderr


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals between processes")
def test_sigterm_while_a_command_imports_is_a_line_and_143(tmp_path):
    ended = run(tmp_path, "SIGTERM", "eval.py")
    assert (ended.returncode, ended.stderr) == (143, "stopped by SIGTERM\n")


def test_a_program_of_ones_own_is_left_alone(tmp_path):
    (tmp_path / "mine.py").write_text("import drillrig_env.env.core\n")
    assert "KeyboardInterrupt" in run(tmp_path, "SIGINT", str(tmp_path / "mine.py")).stderr
    assert "KeyboardInterrupt" in run(tmp_path, "SIGINT", "-c", "import drillrig_env.env.core").stderr
    assert not starting.is_command()


def test_where_imports_end_signals_do_what_they_did():
    earlier = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        for ignored in (signal.default_int_handler, signal.SIG_IGN):
            signal.signal(signal.SIGINT, ignored)
            starting.imports_begin()
            assert (signal.getsignal(signal.SIGINT) is starting._end) == (ignored is signal.default_int_handler)
            starting.imports_end()
            assert signal.getsignal(signal.SIGINT) is ignored
    finally:
        signal.signal(signal.SIGINT, earlier)
