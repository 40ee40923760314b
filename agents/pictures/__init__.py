"""Pictures of the shipped agents: how they learnt, and what they do.

| file | shows |
|---|---|
| `learning.png` | mitigated share over training steps, every seed |
| `histories.png` | one rig over time under rivals and the agent, from the same start |
| `plane.png` | the agent's action over twist and bit speed beside the torque law's |
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

from agents.pictures.learning import plot_learning
from agents.pictures.one_rig import plot_one_rig
from agents.pictures.phase_plane import plot_plane
from agents.policy.run_folder import TRAINED
from drillrig_env.evaluation.pictures import draw

__all__ = ["draw_all", "plot_learning", "plot_one_rig", "plot_plane"]


def draw_all(agent: str, folder: Path, trained: Path = TRAINED) -> list[Path]:
    """Draw all pictures into a folder, those of behaviour with one shipped agent; their paths."""
    plots = {
        "learning": partial(plot_learning, trained),
        "histories": partial(plot_one_rig, agent, trained),
        "plane": partial(plot_plane, agent, trained),
    }
    return [path for name, plot in plots.items() for path in draw(plot, folder, name)]
