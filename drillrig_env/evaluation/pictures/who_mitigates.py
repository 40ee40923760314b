"""The map of who mitigates what over target and normal force, a panel a policy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes

from drillrig_env.evaluation.pictures.naming import suite_words
from drillrig_env.evaluation.results import MARKS, Results, label
from drillrig_env.evaluation.scores import folds
from drillrig_env.evaluation.tables import Scores, best_first
from drillrig_env.plots.style import BLUE, DARK, GREEN, VERMILLION, Picture, new_figure
from drillrig_env.scales import Scales
from drillrig_env.stability import critical_speed

_COLUMNS = 3
_OUTCOMES = (
    ("mitigated", BLUE, "o", 3.0),
    ("calm, but not at the target", GREEN, "^", 3.6),
    ("not calm", VERMILLION, "x", 3.2),
)


def plot_map(results: Results, suite: str) -> Picture:
    """A dot a rig, by what became of it, with critical speed and fold of the nominal friction."""
    scores = results.scores[suite]
    policies = best_first(scores)
    columns = min(_COLUMNS, len(policies))
    lines = -(-len(policies) // columns)
    figure = new_figure(0.7 + 2.0 * lines)
    panels = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
    for panel, policy in zip(panels.flat, policies, strict=False):
        _outcomes(panel, scores[policy], results.scales)
        panel.set_title(f"{label(policy, results.marks)}: {scores[policy]['mitigated'].mean():.1%}")
    for panel in panels.flat[len(policies) :]:
        panel.set_visible(False)
    for column in range(columns):
        last = panels[(len(policies) - 1 - column) // columns, column]
        last.tick_params(labelbottom=True)
        last.set_xlabel(r"target $\omega^*$, rad/s")
    for panel in panels[:, 0]:
        panel.set_ylabel(r"normal force $N_1$, N")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=5, markerscale=1.6)
    caption = (
        f"Who mitigates what, {suite_words(results, suite)}; the share behind a name is that of mitigated rigs. "
        "Lines: critical speed and fold of the nominal friction; those of a rig lie elsewhere, as its friction does. "
        f"{MARKS}."
    )
    return Picture(figure, caption)


def _outcomes(panel: Axes, scores: Scores, scales: Scales) -> None:
    """The rigs of one policy (of its first training seed), and the two lines of the physics."""
    first = scores["seed"] == scores["seed"][0]
    target, force = scores["speed_target"][first], scores["normal_force"][first]
    mitigated, calm = scores["mitigated"][first], scores["calm"][first]
    large = 1.0 if len(target) > 200 else 1.5
    for chosen, (name, color, marker, size) in zip((mitigated, calm & ~mitigated, ~calm), _OUTCOMES, strict=True):
        panel.plot(
            target[chosen], force[chosen], marker, color=color, ms=large * size * 0.6, mew=0.6, label=name, alpha=0.85
        )
    rig = scales.rig
    forces = np.linspace(max(float(force.min()), scales.force), float(force.max()), 200)
    friction = replace(scales.friction, normal_force=forces)
    panel.plot(critical_speed(rig, friction), forces, color=DARK, lw=1.2, label=r"critical speed $\omega_c$")
    panel.plot(folds(rig, friction), forces, color=DARK, lw=1.2, ls=(0, (4, 2)), label="fold")
    panel.set_xlim(float(target.min()) - 0.1 * scales.speed, float(target.max()) + 0.1 * scales.speed)
    panel.set_ylim(float(force.min()) - 0.6 * scales.force, float(force.max()) + 0.6 * scales.force)
