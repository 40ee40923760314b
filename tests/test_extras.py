"""A clone without PyTorch: what needs no agent works, and what needs one says in a line what to install."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from drillrig_env import starting
from drillrig_env.extras import advice

ROOT = Path(__file__).parents[1]
ABSENT = "raise ModuleNotFoundError(\"No module named '{0}'\", name='{0}')\n"


@pytest.fixture
def run(tmp_path):
    """Python as it is where neither PyTorch nor Stable-Baselines3 is installed."""
    (tmp_path / "absent").mkdir()
    for name in ("torch", "stable_baselines3"):
        (tmp_path / "absent" / f"{name}.py").write_text(ABSENT.format(name))
    paths = os.pathsep.join([str(tmp_path / "absent"), str(ROOT)])

    def run(*words):
        settings = {**os.environ, "PYTHONPATH": paths}
        return subprocess.run([sys.executable, *words], env=settings, cwd=ROOT, capture_output=True, text=True)

    return run


@pytest.mark.slow
def test_agents_are_named_in_the_help_and_others_compete(run, tmp_path):
    told = run("-m", "drillrig_env.cli", "evaluate", "--help")
    assert told.returncode == 0, told.stderr
    assert "ppo_surface" in told.stdout
    words = ("--suite", "default", "--rigs", "5", "--no-pictures", "--output", str(tmp_path / "results"))
    done = run("eval.py", "constant", "ppo", *words)
    assert done.returncode == 1
    assert (tmp_path / "results" / "results.json").exists()
    assert "a trained agent needs PyTorch and Stable-Baselines3; in a clone" in done.stdout + done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ["train.py"],
        ["-m", "drillrig_env.cli", "train", "--help"],
        ["-m", "agents.export", "ppo"],
        ["-m", "agents.compare", "ablations"],
        ["-m", "benchmarks.training"],
    ],
)
def test_a_command_that_needs_agents_says_what_to_install(words, run):
    ended = run(*words)
    assert ended.returncode == 1
    (line,) = ended.stderr.splitlines()
    assert line.startswith("error: ")
    assert line.endswith("in a clone of DrillRig: pip install -e '.[agents]'")


@pytest.mark.parametrize(
    "error",
    [
        ModuleNotFoundError("No module named 'nothing'", name="nothing"),
        ImportError("cannot import name 'x' from 'torch'", name="torch"),
    ],
)
def test_other_imports_that_fail_keep_their_traceback(error, capsys):
    assert advice(error) is None
    starting._tell(type(error), error, None)
    assert capsys.readouterr().err.splitlines() == [f"{type(error).__name__}: {error}"]
