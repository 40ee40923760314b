"""One rig over time under a few policies: speeds above, string torque below."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from drillrig_env.evaluation.histories import Histories, History, times, typical_rigs, worth_showing
from drillrig_env.evaluation.results import MARKS, Results, label
from drillrig_env.plots.style import BLUE, DARK, PURPLE, TIME, VERMILLION, Picture, new_figure

_WORDS = {"below": "below its critical speed", "bistable": "between its critical speed and its fold"}


def plot_histories(
    results: Results, histories: Histories, suite: str, region: str, policies: list[str] | None = None
) -> Picture:
    """Bit speed, speed reference and string torque of a region's typical rig, a column a policy.

    By default those of `worth_showing`.
    """
    kept = histories.of(suite, region)
    scores = results.scores[suite]
    first = next(iter(kept))
    chosen = policies or worth_showing(scores, kept)
    rig = typical_rigs(scores[first])[region]
    target, omega_c, fold = (float(scores[first][name][rig]) for name in ("speed_target", "critical_speed", "fold"))
    scales = results.scales
    figure = new_figure(3.5)
    panels = figure.subplots(2, len(chosen), sharex=True, sharey="row", squeeze=False, height_ratios=(1.7, 1.0))
    for column, policy in enumerate(chosen):
        _speeds(panels[0, column], kept[policy], target, omega_c, scales.time)
        panels[0, column].set_title(label(policy, results.marks))
        panels[1, column].plot(times(kept[policy], scales.time), kept[policy]["torque_into_string"], color=PURPLE)
        panels[1, column].set_xlabel(TIME)
        panels[1, column].xaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
    panels[0, 0].set_ylim(-0.3 * scales.speed, 1.05 * max(float(kept[policy]["highest"].max()) for policy in chosen))
    panels[0, 0].set_ylabel("speed, rad/s")
    panels[1, 0].set_ylabel("string torque, N m")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    one = {name: float(scores[first][name][rig]) for name in ("normal_force", "hardness")}
    where_it_ends = f"fold = {fold:.2f} rad/s, " if np.isfinite(fold) else ""
    caption = (
        f"One rig {_WORDS[region]} under {len(chosen)} policies, suite {suite}, {results.config['env']}: "
        f"ω* = {target:.2f} rad/s, ω_c = {omega_c:.2f} rad/s, {where_it_ends}"
        f"N_1 = {one['normal_force']:.1f} N at the end, q = {one['hardness']:.2f}. "
        f"It is the rig of median hardness in this region. {MARKS}."
    )
    return Picture(figure, caption)


def _speeds(panel: Axes, history: History, target: float, omega_c: float, time_scale: float) -> None:
    time = times(history, time_scale)
    panel.fill_between(time, history["lowest"], history["highest"], color=BLUE, alpha=0.35, lw=0.0)
    panel.plot(time, history["average"], color=BLUE, lw=0.9, label="bit speed")
    panel.plot(time, history["speed_reference"], color=VERMILLION, lw=1.3, label=r"speed reference $\omega_{ref}$")
    panel.axhline(target, color=DARK, lw=0.9, ls=(0, (4, 2)), label=r"target $\omega^*$")
    panel.axhline(omega_c, color=DARK, lw=0.9, ls=(0, (1, 1.5)), label=r"critical speed $\omega_c$")
    panel.set_xlim(0.0, float(np.max(time)))
