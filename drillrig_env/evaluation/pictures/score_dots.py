"""Every policy's scores with their intervals, as dots on lines."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from drillrig_env.evaluation.pictures.naming import suite_words
from drillrig_env.evaluation.results import MARKS, Results, label
from drillrig_env.evaluation.statistics import Estimate
from drillrig_env.evaluation.tables import MAIN, OTHERS, Row, best_first, estimates
from drillrig_env.plots.style import BLUE, DARK, GREEN, VERMILLION, Picture, new_figure
from drillrig_env.scales import DURATION
from drillrig_env.verdict import WINDOW

_REGIONS = (("below ω_c", VERMILLION, "s"), ("bistable", BLUE, "o"), ("above", GREEN, "^"))
_LABELS = {"below ω_c": r"below $\omega_c$", "bistable": "bistable", "above": "above the fold"}


def plot_scores(results: Results, suite: str) -> Picture:
    """Mitigated, the same by region, time to calm and cost; policies from best to worst."""
    scores = results.scores[suite]
    policies = best_first(scores)
    table = {policy: estimates(scores[policy], MAIN.columns + OTHERS.columns) for policy in policies}
    figure = new_figure(1.3 + 0.27 * len(policies))
    panels = figure.subplots(1, 4, sharey=True, width_ratios=(1.0, 1.25, 1.0, 1.0))
    places = np.arange(len(policies))[::-1]
    _dots(panels[0], places, table, "mitigated", DARK, "o")
    for shift, (heading, color, marker) in zip((0.22, 0.0, -0.22), _REGIONS, strict=True):
        _dots(panels[1], places + shift, table, heading, color, marker, _LABELS[heading])
    _dots(panels[2], places, table, "to calm", DARK, "o")
    _dots(panels[3], places, table, "cost", DARK, "o")
    titles = ("mitigated", "mitigated by region", "time to calm", "cost")
    for panel, title in zip(panels, titles, strict=True):
        panel.set_title(title)
        panel.tick_params(axis="y", length=0)
    for panel in panels[:2]:
        panel.set_xlim(-0.04, 1.04)
        panel.set_xticks([0.0, 0.5, 1.0], ["0", "0.5", "1"])
        panel.set_xlabel("share of rigs")
    longest = DURATION * results.scales.duration
    panels[2].set_xlim(-longest / 30.0, longest * 31.0 / 30.0)
    panels[2].xaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
    panels[2].set_xlabel(f"median, s; {longest:.3g}: never")
    panels[3].set_xscale("log")
    panels[3].xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    panels[3].xaxis.set_major_formatter("{x:g}")
    panels[3].xaxis.set_minor_formatter(NullFormatter())
    panels[3].set_xlabel("mean, log scale")
    panels[0].set_yticks(places, [label(policy, results.marks) for policy in policies])
    panels[0].set_ylim(-0.6, len(policies) - 0.4)
    figure.legend(*panels[1].get_legend_handles_labels(), loc="outside upper right", ncols=3)
    caption = (
        f"Scores of every policy, {suite_words(results, suite)}; bars: intervals at 95\N{NO-BREAK SPACE}%. Mitigated: "
        f"the last {WINDOW * results.scales.time:.3g} s are calm and within 5\N{NO-BREAK SPACE}% of the target speed. "
        "Below the critical speed ω_c steady rotation is unstable; from there to the fold both it and stick-slip are "
        "stable (bistable). "
        f"{MARKS}."
    )
    return Picture(figure, caption)


def _dots(
    panel: Axes, places: np.ndarray, table: dict[str, Row], heading: str, color: str, marker: str, name: str = ""
) -> None:
    """One dot a policy with its interval as a bar; none where there was nothing to estimate."""
    for first, (place, row) in enumerate(zip(places, table.values(), strict=True)):
        one: Estimate = row[heading]
        if one.count:
            panel.plot([one.low, one.high], [place, place], color=color, lw=1.4, solid_capstyle="butt")
        shown = [one.value] if one.count else []
        panel.plot(shown, [place] * len(shown), marker, color=color, ms=4.2, label=name if first == 0 else None)
