"""Every script of the gallery runs to its end, is short, and draws a picture that has a title and units."""

import ast
import runpy
import sys
from pathlib import Path

import matplotlib
import pytest

matplotlib.use("Agg")

import matplotlib.pyplot as plt

ROOT = Path(__file__).parents[1]
SCRIPTS = sorted((ROOT / "examples").glob("*.py"))
SLOW = (
    "agent_against_lqg",
    "calibrate_a_twin",
    "drift",
    "figure_for_a_paper",
    "fleet",
    "own_controller",
    "ppo_in_two_minutes",
    "sweep_on_ray",
)
ARGUMENTS = {"ppo_in_two_minutes": ["20000"]}


def marks(script):
    slow = [pytest.mark.slow] if script.stem in SLOW else []
    return slow + ([pytest.mark.clients] if script.stem == "offline_data" else [])


@pytest.mark.filterwarnings("ignore:FigureCanvasAgg is non-interactive")
@pytest.mark.parametrize("script", [pytest.param(one, id=one.stem, marks=marks(one)) for one in SCRIPTS])
def test_example_runs_and_draws(script, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    monkeypatch.setattr(sys, "argv", [str(script), *ARGUMENTS.get(script.stem, [])])
    plt.close("all")
    runpy.run_path(str(script), run_name="__main__")
    drawn = [axes for number in plt.get_fignums() for axes in plt.figure(number).axes]
    assert drawn
    assert all(axes.has_data() for axes in drawn)
    assert any(axes.get_title() for axes in drawn)
    assert [path.name for path in tmp_path.iterdir() if path.suffix == ".png"] == []
    plt.close("all")


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_examples_are_short_and_say_what_they_show(script):
    text = script.read_text(encoding="utf-8")
    title, rule, *_ = (ast.get_docstring(ast.parse(text)) or "").splitlines()
    assert rule == "=" * len(title)
    assert len(text.splitlines()) <= 60
