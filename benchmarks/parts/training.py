"""Training: speed, seconds to the goal, and where the time goes."""

from __future__ import annotations

import numpy as np

from benchmarks.parts.part import RIG, Part, Results, amount, duration
from drillrig_env import markdown
from drillrig_env.plots.style import BLUE, GREEN, GREY, VERMILLION, Picture, new_figure

_PHASES = {"env": ("environment", BLUE), "policy": ("policy", GREEN), "update": ("update", VERMILLION)}
_PHASES["other"] = ("rest: buffers, logs, callbacks", GREY)


def result(results: Results) -> list[tuple[str, str]]:
    """Speed, and seconds to the goal, on one core."""
    lines = []
    for row in results["rows"]:
        if row["environment"] == RIG and row["cores"] == 1:
            goal, name = row["seconds_to_goal"], f"{row['algorithm'].upper()} on one core"
            lines.append((f"training, {name}", f"**{amount(row['steps_per_second'])} steps/s**"))
            if goal is not None:
                words = f"until {results['goal']:g} are mitigated on the softened drive, where action 0 has 0.99"
                lines.append((f"training, {name}, {words}", f"**{duration(goal)}**"))
    return lines


def tables(results: Results) -> list[str]:
    """Speed, goal and shares of time, a row a setting."""
    rows = []
    for row in results["rows"]:
        asked = "not reached" if row["runs_to_goal"] else "-"
        goal = [
            asked if row[key] is None else format(row[key], digits)
            for key, digits in (("seconds_to_goal", ".1f"), ("steps_to_goal", ",.0f"))
        ]
        shares = [f"{row[f'{phase}_percent']:.1f}" for phase in ("env", "policy", "update", "other")]
        numbers = [str(row[key]) for key in ("n_envs", "cores", "torch_threads")]
        speeds = [f"{row['steps_per_second']:,.0f}", f"{row['env_steps_per_second']:,.0f}"]
        rows.append([row["algorithm"].upper(), row["environment"], *numbers, *speeds, *goal, *shares])
    heads = ["algorithm", "environment", "copies", "cores", "PyTorch threads", "steps/s", "steps/s, env alone"]
    heads += [f"s to {results['goal']:g}", f"steps to {results['goal']:g}", "env %", "policy %", "update %", "rest %"]
    return [markdown.table(heads, rows, words=2)]


def plot(results: Results, made: str) -> Picture:
    """Shares of a training's time as stacked bars, a bar a setting, with its speed."""
    rows = results["rows"]
    names = [training_name(row) for row in rows]
    figure = new_figure(0.9 + 0.24 * len(rows))
    panel = figure.subplots()
    places = np.arange(len(rows))[::-1]
    before = np.zeros(len(rows))
    for phase, (words, color) in _PHASES.items():
        shares = np.array([row[f"{phase}_percent"] for row in rows])
        panel.barh(places, shares, left=before, height=0.7, color=color, label=words)
        before += shares
    for place, row in zip(places, rows, strict=True):
        panel.text(101.0, place, f"{row['steps_per_second']:,.0f} steps/s", va="center")
    panel.set_yticks(places, names)
    panel.tick_params(axis="y", length=0)
    panel.grid(axis="y", visible=False)
    panel.set_xlim(0.0, 100.0)
    panel.set_xlabel("share of the time, %")
    figure.legend(*panel.get_legend_handles_labels(), loc="outside upper center", ncols=len(_PHASES))
    caption = (
        "Where the time of a training goes: steps and resets of the environments, the network's answers while "
        "experience is collected, gradient steps, and the rest; beside each bar environment steps a second of the "
        f"whole training. Pendulum-v1 is stepped by Stable-Baselines3's DummyVecEnv. {made}"
    )
    return Picture(figure, caption)


def training_name(row: Results) -> str:
    """Algorithm, environment and cores of a row, short."""
    cores = f"{row['cores']} core{'s' if row['cores'] > 1 else ''}"
    threads = f", {row['torch_threads']} for PyTorch" if row["torch_threads"] > 1 else ""
    return f"{row['algorithm'].upper()}, {row['environment']}, {cores}{threads}"


TRAINING = Part(
    "training",
    "Training",
    """PPO and SAC as `train.py` runs them, with the hyperparameters of the softened drive; for comparison
Pendulum-v1 from Stable-Baselines3's own vector environment with the same settings. Seconds and steps to the goal are
medians over seeds, validation not counted. On this drive a reference that nobody moves mitigates 0.99: the times say
how fast the program is, not what an agent is worth; that is on [the page of agents](agents.md).""",
    result,
    tables,
    plot,
    "Where the time of a training goes",
)
