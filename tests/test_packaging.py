"""What is installed: the wheel's contents, its entry points, and that it works where nothing else of the project is."""

import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

import drillrig_env
from baselines import BASELINES
from drillrig_env.extras import missing

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

AT_WORK = """
import gymnasium as gym
import drillrig_env
from drillrig_env.evaluation.runner import run
from drillrig_env.evaluation.scores import score
from drillrig_env.evaluation.suites import suite
from drillrig_env.policy import make_policy, policy_names
from drillrig_env.stability import fold_speed

env = gym.make("DrillRig-v0", rig={"k_1": 1.0})
env.reset(seed=0)
env.step(env.action_space.sample())
print("fold", round(fold_speed(drillrig_env.Rig(), drillrig_env.Friction(10.0)), 3))
for name in ("constant", "lqg"):
    print(name, score(run(make_policy(name), suite("default", 50)))["mitigated"].mean())
print(len(policy_names()), drillrig_env.__file__)
"""


def test_every_baseline_is_an_entry_point_by_its_name():
    offered = PROJECT["entry-points"]["drillrig.policies"]
    assert offered == {name: f"baselines:{policy.__name__}" for name, policy in BASELINES.items()}


def test_the_command_line_is_a_script():
    assert PROJECT["scripts"] == {"drillrig": "drillrig_env.cli:main"}


def test_every_dependency_has_a_lower_bound():
    extras = PROJECT["optional-dependencies"]
    runtime = [
        *PROJECT["dependencies"],
        *(
            one
            for name in ("agents", "deploy", "export", "opcua", "plot", "posterior", "records", "render", "scale")
            for one in extras[name]
        ),
    ]
    assert [one for one in runtime if ">=" not in one] == []


@pytest.mark.parametrize(
    "extra", ["agents", "deploy", "export", "opcua", "plot", "posterior", "records", "render", "scale"]
)
def test_hints_of_what_to_install_name_an_extra_that_exists(extra):
    assert extra in PROJECT["optional-dependencies"]
    assert f"pip install -e '.[{extra}]'" in str(missing("this", "that", extra))


def test_no_hint_names_the_package_as_if_it_were_on_an_index():
    sources = [path for folder in ("drillrig_env", "baselines", "agents") for path in (ROOT / folder).rglob("*.py")]
    assert [path for path in sources if "pip install 'drillrig" in path.read_text(encoding="utf-8")] == []


def test_the_change_log_describes_this_version_or_says_that_it_is_to_come():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"\n## {drillrig_env.__version__}, " in text or "\n## Unreleased\n" in text


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The folder with wheel and sdist, built by the standard front end in an environment of its own."""
    folder = tmp_path_factory.mktemp("built")
    for name in ("drillrig_env", "baselines"):
        shutil.copytree(ROOT / name, folder / "source" / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder / "source" / name)
    python = environment(folder / "builder")
    run(python, "-m", "pip", "install", "--quiet", "build")
    run(python, "-m", "build", "--outdir", folder / "dist", folder / "source")
    return folder / "dist"


def environment(folder):
    """An empty environment; its Python."""
    venv.create(folder, with_pip=True)
    return folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def run(*words, **settings):
    alone = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    words = [str(word) for word in words]
    done = subprocess.run(words, capture_output=True, text=True, env=alone, check=False, **settings)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def top_level(names):
    return {name.split("/")[0] for name in names}


@pytest.mark.slow
def test_the_wheel_brings_the_two_packages_with_their_data_and_nothing_else(built):
    (wheel,) = built.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    version = drillrig_env.__version__
    assert top_level(names) == {"drillrig_env", "baselines", f"drillrig-{version}.dist-info"}
    assert {"drillrig_env/py.typed", "baselines/tuned.json", "drillrig_env/deploy/shipped/lqg.onnx"} <= set(names)
    sources = {
        path.relative_to(ROOT).as_posix()
        for name in ("drillrig_env", "baselines")
        for path in (ROOT / name).rglob("*.py")
    }
    assert sources <= set(names)


@pytest.mark.slow
def test_the_sdist_holds_what_the_wheel_is_made_of(built):
    (sdist,) = built.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {
        "pyproject.toml",
        "README.md",
        "LICENSE",
        "drillrig_env/deploy/shipped/lqg.onnx",
        "drillrig_env/py.typed",
    } <= names
    assert not any(name.startswith("agents") for name in names)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["*.whl", "*.tar.gz"])
def test_an_empty_environment_with_it_makes_the_environment_takes_a_fold_and_evaluates(built, kind, tmp_path):
    (package,) = built.glob(kind)
    python = environment(tmp_path / "empty")
    run(python, "-m", "pip", "install", "--quiet", package)
    run(python, "-m", "pip", "check")
    said = run(python, "-c", AT_WORK, cwd=tmp_path)
    lines = dict(line.split(maxsplit=1) for line in said.splitlines())
    assert lines["fold"] == "2.901"
    assert float(lines["lqg"]) > 0.9 > 0.5 > float(lines["constant"])
    count, place = said.splitlines()[-1].split(maxsplit=1)
    assert int(count) == len(BASELINES)
    assert Path(place).is_relative_to(tmp_path)
    command = python.with_name("drillrig.exe" if sys.platform == "win32" else "drillrig")
    assert "drillrig info --write my_rig.toml" in run(command, "--help", cwd=tmp_path)
    assert "omega_c" in run(command, "info", "--normal-force", "20", cwd=tmp_path)
    evaluated = run(
        command, "evaluate", "constant", "lqg", "--suite", "default", "--rigs", "50", "--no-pictures", cwd=tmp_path
    )
    assert "lqg" in evaluated
    assert (tmp_path / "results" / "results.json").is_file()
