"""How the shipped agents learnt: mitigated share over training steps, seed by seed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from agents.policy.run_folder import TRAINED, read_config, read_seeds
from drillrig_env.arrays import FloatArray
from drillrig_env.evaluation.statistics import interquartile_mean
from drillrig_env.markdown import listed
from drillrig_env.plots.style import BLUE, DARK, Picture, new_figure


def learning_curves(seeds: Mapping[str, Any]) -> tuple[FloatArray, FloatArray]:
    """Steps, shape (k,), and mitigated shares, shape (seeds, k), at the evaluations of the first seed."""
    curves = list(seeds["seeds"].values())
    steps = np.asarray(curves[0]["timesteps"], dtype=float)
    return steps, np.array([np.interp(steps, one["timesteps"], one["mitigated"]) for one in curves])


def plot_learning(trained: Path = TRAINED) -> Picture:
    """A panel an agent: every seed thin, their interquartile mean thick. `ValueError` where no agent is shipped."""
    found = {path.name: seeds for path in sorted(trained.glob("*")) if (seeds := read_seeds(path)) is not None}
    if not found:
        raise ValueError(f"{trained} holds no shipped agent; make one with: python -m agents.shipping.ship")
    figure = new_figure(2.3)
    panels = figure.subplots(1, len(found), sharey=True, squeeze=False)[0]
    for panel, (name, seeds) in zip(panels, found.items(), strict=True):
        steps, shares = learning_curves(seeds)
        millions = steps / 1e6
        for share in shares:
            panel.plot(millions, share, color=BLUE, lw=0.7, alpha=0.6)
        panel.plot(millions, interquartile_mean(shares, axis=0), color=DARK, lw=2.0)
        panel.set_title(f"{name}\n{read_config(trained / name)['env_id']}")
        panel.set_xlim(0.0, float(millions[-1]))
        panel.set_xlabel("million steps")
    panels[0].set_ylim(-0.02, 1.02)
    panels[0].set_ylabel("share of rigs mitigated")
    count = {len(seeds["seeds"]) for seeds in found.values()}
    rigs = {read_config(trained / name)["eval_episodes"] for name in found}
    caption = (
        "Learning curves of the shipped agents: share of rigs mitigated in the evaluations during training "
        f"({listed(sorted(rigs), 'or')} rigs of the training side from developed stick-slip, no exploration), for "
        f"each of {listed(sorted(count), 'or')} seeds (thin) and as interquartile mean over them (thick). One million "
        "steps are 28 hours of drilling."
    )
    return Picture(figure, caption)
