"""Pictures of the shipped agents: how they learnt, and what they do.

| file | shows |
|---|---|
| `learning.png` | mitigated share over training steps, every seed |
| `histories.png` | one rig over time under rivals and the agent, from the same start |
| `plane.png` | the agent's action over twist and bit speed beside the torque law's |
| `noise_and_delay.png` | mitigated share over the delay of measurements |
| `beside_<agent>.png` | a hard rig under LQG and under that agent, and the rates that both ask for |
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from agents.beside_lqg import hard_rig, picture_name
from agents.pictures.beside_lqg import plot_beside
from agents.pictures.learning import plot_learning
from agents.pictures.noise_and_delay import plot_noise_and_delay
from agents.pictures.one_rig import plot_one_rig
from agents.pictures.phase_plane import plot_plane
from agents.policy.run_folder import TRAINED
from drillrig_env.evaluation.pictures import draw
from drillrig_env.evaluation.results import Results
from drillrig_env.plots.style import Picture

__all__ = ["draw_all", "plot_beside", "plot_learning", "plot_noise_and_delay", "plot_one_rig", "plot_plane"]


def draw_all(
    agent: str,
    folder: Path,
    trained: Path = TRAINED,
    results: Mapping[str, Results] = MappingProxyType({}),
    late: Mapping[str, Any] | None = None,
) -> list[Path]:
    """Draw all pictures into a folder, those of behaviour with one shipped agent; their paths.

    `results` are the stored results with an agent and with LQG, by agent: each gets a picture beside it.
    `late` is what `agents.noise_and_delay` has found, if it has run.
    """
    plots: dict[str, Callable[[], Picture]] = {
        "learning": partial(plot_learning, trained),
        "histories": partial(plot_one_rig, agent, trained),
        "plane": partial(plot_plane, agent, trained),
    }
    if late:
        plots["noise_and_delay"] = partial(plot_noise_and_delay, late)
    for name, found in results.items():
        if hard_rig(found, name):
            plots[picture_name(name)] = partial(plot_beside, name, found, trained)
    return [path for name, plot in plots.items() for path in draw(plot, folder, name)]
