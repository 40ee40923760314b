"""RL Baselines3 Zoo trains on the environment from its command line, and plays what it has trained."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from agents.training.hyperparameters import HYPERPARAMETER_FILES

pytestmark = pytest.mark.clients
pytest.importorskip("rl_zoo3", reason="needs the extra clients")

SETTINGS = """\
{name}:
  n_envs: 2
  n_timesteps: 64
  policy: MlpPolicy
  n_steps: 16
  batch_size: 16
  n_epochs: 1
  normalize: true
"""


PAGE = Path(__file__).parents[2] / "docs" / "environment.md"


def run(*words, folder):
    done = subprocess.run([sys.executable, "-m", *words], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("vec_env", ["dummy", "subproc"])
def test_train_and_enjoy(tmp_path, vec_env):
    name = "DrillRig-v0"
    (tmp_path / "ppo.yml").write_text(SETTINGS.format(name=name), encoding="utf-8")
    common = ("--algo", "ppo", "--env", name, "--gym-packages", "drillrig_env", "--seed", "1", "-f", "logs")
    arguments = ("--env-kwargs", "duration:1.0", "rig:{'J_1': 0.03}", "--vec-env", vec_env, "--conf-file", "ppo.yml")
    out = run("rl_zoo3.train", *common, *arguments, "--eval-freq", "20", "--eval-episodes", "2", folder=tmp_path)
    assert "success_rate" in out
    assert (tmp_path / f"logs/ppo/{name}_1/{name}.zip").is_file()
    played = run("rl_zoo3.enjoy", *common, "-n", "20", "--no-render", folder=tmp_path)
    assert "Loading" in played


def test_example_of_the_page_runs(tmp_path):
    page = PAGE.read_text(encoding="utf-8")
    (settings,) = re.findall(r"```yaml\n(DrillRig-v0:.*?)```", page, re.DOTALL)
    (tmp_path / "ppo.yml").write_text(settings, encoding="utf-8")
    (command,) = re.findall(r"^python -m (rl_zoo3.*)$", page, re.MULTILINE)
    run(*shlex.split(command), "-n", "128", folder=tmp_path)
    assert (tmp_path / "logs/ppo/DrillRig-v0_1/DrillRig-v0.zip").is_file()


@pytest.mark.parametrize("folder", ["alone", "soft_drive"])
@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_files_of_the_agents_train_as_they_are(tmp_path, algorithm, folder):
    settings = HYPERPARAMETER_FILES / folder / f"{algorithm}.yml"
    few = {"ppo": ("n_steps:16", "batch_size:16"), "sac": ("learning_starts:20", "batch_size:16", "gradient_steps:1")}
    words = ("--algo", algorithm, "--env", "DrillRig-v0", "--gym-packages", "drillrig_env", "-conf", str(settings))
    quick = ("-n", "64", "--eval-freq", "-1", "-f", "runs", "-params", "n_envs:2", *few[algorithm])
    run("rl_zoo3.train", *words, *quick, folder=tmp_path)
    assert (tmp_path / f"runs/{algorithm}/DrillRig-v0_1/DrillRig-v0.zip").is_file()
