"""Pictures of a comparison: one rig's history under each policy, and the map of who mitigates what."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from drillrig_env.env.kernel import CONTROL_PERIOD
from drillrig_env.evaluation.runner import Episodes
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.stability import critical_speed, fold_speed

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.figure import Figure
except ImportError as error:
    raise ImportError("pictures need Matplotlib; install it with: pip install 'drillrig[plot]'") from error

_BIT, _TOP, _REFERENCE = "#1f5fa8", "#5aa84f", "#d1651f"
_GOOD, _BAD = "#1f5fa8", "#d1651f"


def plot_histories(runs: Mapping[str, Episodes], rig: int, path: Path) -> None:
    """Bit speed, top speed and speed reference of one rig of a suite over time, a panel a policy, as PNG.

    The bit speed is a band from its lowest to its highest value in each control step.
    """
    first = next(iter(runs.values()))
    target, friction = float(first.speed_target[rig]), Friction(*first.friction.as_array()[rig].tolist())
    figure, panels = plt.subplots(
        len(runs), 1, figsize=(8, 1.4 + 1.9 * len(runs)), sharex=True, sharey=True, squeeze=False
    )
    for panel, (name, episodes) in zip(panels[:, 0], runs.items(), strict=True):
        time = CONTROL_PERIOD * np.arange(1, episodes.lowest.shape[1] + 1)
        panel.fill_between(time, episodes.lowest[rig], episodes.highest[rig], color=_BIT, lw=0.8, label="bit speed")
        panel.plot(time, episodes.average[rig], color=_BIT, lw=1.0)
        panel.plot(time, episodes.top_speed[rig], color=_TOP, lw=2.4, label="top speed")
        panel.plot(time, episodes.speed_reference[rig], color=_REFERENCE, lw=1.1, label="speed reference")
        panel.axhline(target, color="0.1", lw=1.0, ls="--", label="target")
        panel.axhline(
            float(critical_speed(episodes.rig, friction)), color="0.1", lw=1.2, ls=":", label="critical speed"
        )
        panel.set_title(name, loc="left", fontsize=10)
        panel.set_ylabel("speed, rad/s")
        panel.grid(alpha=0.25)
    panels[-1, 0].set_xlabel("time, s")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=5, fontsize=9, frameon=False)
    force = float(friction.normal_force)
    figure.suptitle(f"One rig under each policy: target {target:.2f} rad/s, normal force {force:.1f} N", fontsize=11)
    _save(figure, path)


def plot_map(runs: Mapping[str, Mapping[str, np.ndarray]], rig: Rig, path: Path) -> None:
    """Who mitigates what over target and normal force, a panel a policy, with critical speed and fold, as PNG."""
    columns = 2 if len(runs) in (2, 4) else min(3, len(runs))
    rows = -(-len(runs) // columns)
    figure, panels = plt.subplots(
        rows, columns, figsize=(1.0 + 3.6 * columns, 0.9 + 3.3 * rows), sharex=True, sharey=True, squeeze=False
    )
    for panel, (name, scores) in zip(panels.flat, runs.items(), strict=False):
        target, force, good = scores["speed_target"], scores["normal_force"], scores["mitigated"]
        panel.scatter(target[good], force[good], s=9, color=_GOOD, lw=0, label="mitigated")
        panel.scatter(target[~good], force[~good], s=13, color=_BAD, marker="x", lw=0.9, label="not")
        forces = np.linspace(max(force.min(), 1.0), force.max(), 200)
        panel.plot(critical_speed(rig, Friction(forces)), forces, color="0.1", lw=1.4, label="critical speed")
        panel.plot(fold_speed(rig, Friction(forces)), forces, color="0.1", lw=1.4, ls="-.", label="fold")
        panel.set_xlim(target.min() - 0.1, target.max() + 0.1)
        panel.set_title(f"{name}: {good.mean():.0%} mitigated", loc="left", fontsize=10)
        panel.grid(alpha=0.2)
    for panel in panels.flat[len(runs) :]:
        panel.set_visible(False)
    for panel in panels[-1]:
        panel.set_xlabel("target speed, rad/s")
    for panel in panels[:, 0]:
        panel.set_ylabel("normal force, N")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=4, fontsize=9, frameon=False)
    figure.suptitle("Critical speed and fold are drawn for the nominal friction; each rig has its own", fontsize=9)
    _save(figure, path)


def _save(figure: Figure, path: Path) -> None:
    """Save with room for the legend below."""
    inches = 0.35
    figure.tight_layout(rect=(0.0, inches / figure.get_size_inches()[1], 1.0, 1.0))
    figure.savefig(path, dpi=150)
    plt.close(figure)
