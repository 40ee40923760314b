"""How the shipped agents learnt: mitigated share over training steps, seed by seed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from agents.policy.action_zero import ActionZero
from agents.policy.environment import environment_arguments
from agents.policy.run_folder import TRAINED, read_config, read_seeds, shipped
from agents.training.validation_rigs import validate
from drillrig_env.arrays import FloatArray
from drillrig_env.evaluation.statistics import interquartile_mean
from drillrig_env.markdown import listed
from drillrig_env.plots.style import BLUE, DARK, VERMILLION, Picture, new_figure

_COLUMNS = 4  # panels side by side


def learning_curves(seeds: Mapping[str, Any]) -> tuple[FloatArray, FloatArray]:
    """Steps, shape (k,), and mitigated shares, shape (seeds, k), at the evaluations of the first seed."""
    curves = list(seeds["seeds"].values())
    steps = np.asarray(curves[0]["timesteps"], dtype=float)
    return steps, np.array([np.interp(steps, one["timesteps"], one["mitigated"]) for one in curves])


def action_zero(config: Mapping[str, Any]) -> float:
    """The share that is mitigated where the reference stays at the target, on the rigs and the drive of the curves."""
    arguments = environment_arguments(config["env_id"], config["env_kwargs"])
    return float(validate(ActionZero(arguments), arguments, config["eval_episodes"]).mitigated.mean())


def plot_learning(trained: Path = TRAINED) -> Picture:
    """A panel an agent: every seed thin, their interquartile mean thick. `ValueError` where no agent is shipped."""
    found = {name: seeds for name in shipped(trained) if (seeds := read_seeds(trained / name)) is not None}
    if not found:
        raise ValueError(f"{trained} holds no shipped agent; make one with: python -m agents.shipping.ship")
    columns = min(len(found), _COLUMNS)
    rows = -(-len(found) // columns)
    figure = new_figure(0.5 + 1.8 * rows)
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for panel in panels.flat[len(found) :]:
        panel.remove()
    for panel, (name, seeds) in zip(panels.flat, found.items(), strict=False):
        config = read_config(trained / name)
        steps, shares = learning_curves(seeds)
        millions = steps / 1e6
        for share in shares:
            panel.plot(millions, share, color=BLUE, lw=0.7, alpha=0.6)
        panel.plot(millions, interquartile_mean(shares, axis=0), color=DARK, lw=2.0)
        panel.axhline(action_zero(config), color=VERMILLION, ls=(0, (4, 2)), label="action 0, same drive and rigs")
        panel.set_title(f"{name}\n{config['env_id']}")
        panel.set_xlim(0.0, float(millions[-1]))
        panel.set_xlabel("million steps")
    for row in panels:
        row[0].set_ylim(-0.02, 1.02)
        row[0].set_ylabel("share mitigated")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center")
    count = {len(seeds["seeds"]) for seeds in found.values()}
    rigs = {read_config(trained / name)["eval_episodes"] for name in found}
    caption = (
        "Learning curves of the shipped agents: share of rigs mitigated in the evaluations during training "
        f"({listed(sorted(rigs), 'or')} rigs of the training side from developed stick-slip, no exploration), for "
        f"each of {listed(sorted(count), 'or')} seeds (thin) and as interquartile mean over them (thick). Dashed: the "
        "reference that stays at the target. Steps are those by trial: an agent that imitated first begins with what "
        "that brought it. One million steps are 28 hours of drilling."
    )
    return Picture(figure, caption)
