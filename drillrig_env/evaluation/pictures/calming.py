"""How many rigs are calm by when: the distribution of the time to calm under every policy."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from drillrig_env.evaluation.pictures.naming import COLORS, DASHES, suite_words
from drillrig_env.evaluation.results import MARKS, Results, label
from drillrig_env.evaluation.scores import TRAILING
from drillrig_env.evaluation.tables import best_first
from drillrig_env.plots.style import Picture, new_figure
from drillrig_env.scales import CONTROL_PERIOD

_LINE = 0.046  # share of the axis from one label to the next


def plot_calming(results: Results, suite: str) -> Picture:
    """The share of rigs that are calm from a time on and stay so, over that time; a line a policy."""
    scores = results.scores[suite]
    scales = results.scales
    duration = max(float(one["time_to_calm"].max()) for one in scores.values())
    figure = new_figure(3.6)
    panel = figure.subplots()
    ends = {}
    for number, policy in enumerate(best_first(scores)):
        times = np.sort(scores[policy]["time_to_calm"])
        calm = times[times < duration - 0.5 * CONTROL_PERIOD * scales.time]
        share = np.arange(len(calm) + 1) / len(times)
        color, dashes = COLORS[number % len(COLORS)], DASHES[number // len(COLORS) % len(DASHES)]
        panel.step([0.0, *calm, duration], [*share, share[-1]], where="post", color=color, ls=dashes, lw=1.5)
        ends[policy] = (float(share[-1]), color)
    panel.set_xlim(0.0, duration)
    panel.set_ylim(-0.01, 1.01)
    panel.set_xlabel("time from the start of the episode, s")
    panel.set_ylabel("share of rigs that are calm from then on")
    _label_ends(panel, {label(policy, results.marks): end for policy, end in ends.items()}, duration)
    trailing = f"{TRAILING * scales.time:.3g} s"
    caption = (
        f"How fast rigs calm down, {suite_words(results, suite)}. A rig is calm from the time after which its "
        f"stick-slip index over the trailing {trailing} stays below 0.1, which takes {trailing} at least, at whatever "
        f"mean speed. A line ends at the share that is calm at last. {MARKS}."
    )
    return Picture(figure, caption)


def _label_ends(panel: Axes, ends: dict[str, tuple[float, str]], duration: float) -> None:
    """Names right of the lines' ends, moved apart where they would overlap."""
    names = sorted(ends, key=lambda name: ends[name][0])
    places = np.array([ends[name][0] for name in names])
    for place in range(1, len(places)):
        places[place] = max(places[place], places[place - 1] + _LINE)
    beyond = max(0.0, places[-1] - 1.0)
    places -= beyond
    for place in range(len(places) - 2, -1, -1):
        places[place] = min(max(places[place], ends[names[place]][0]), places[place + 1] - _LINE)
    for name, place in zip(names, places.tolist(), strict=True):
        end, color = ends[name]
        panel.annotate(
            f"{name}  {end:.2f}",
            (duration, end),
            (1.04 * duration, place),
            va="center",
            color=color,
            annotation_clip=False,
            arrowprops={
                "arrowstyle": "-",
                "color": color,
                "lw": 0.6,
                "shrinkA": 2.0,
                "shrinkB": 0.0,
                "relpos": (0.0, 0.5),
            },
        )
