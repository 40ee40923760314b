"""Lines over logarithmic axes, named beside their ends: the pictures of solvers, batches and environments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter
from matplotlib.transforms import ScaledTranslation, blended_transform_factory

from benchmarks.parts.part import OWN
from drillrig_env.evaluation.pictures.naming import COLORS, DASHES
from drillrig_env.plots.style import DARK

_MARKERS = "osD^vPX"
_LABEL_HEIGHT = 0.13  # inches


@dataclass(frozen=True)
class Line:
    """A line to be drawn, its name and look; x ascending."""

    name: str
    x: Sequence[float]
    y: Sequence[float]
    style: Mapping[str, Any]


def styled(points: Mapping[str, Any]) -> list[Line]:
    """Lines by name with looks of their own; those of the project are thick and dark."""
    others, own = count(), count()
    lines = []
    for name, (x, y) in points.items():
        if name.startswith(OWN):
            number = next(own)
            look = {"color": DARK, "lw": 2.0, "ls": DASHES[number % len(DASHES)]}
        else:
            number = next(others)
            colors = COLORS[:-1]  # the last is the project's
            look = {"color": colors[number % len(colors)], "ls": DASHES[number // len(colors) % len(DASHES)]}
        lines.append(Line(name, x, y, {**look, "marker": _MARKERS[number % len(_MARKERS)], "ms": 3.2}))
    return lines


def draw_lines(panel: Axes, lines: Sequence[Line]) -> None:
    """Draw lines over logarithmic axes."""
    panel.set_xscale("log")
    panel.set_yscale("log")
    for line in lines:
        panel.plot(line.x, line.y, **line.style)


def name_lines(panel: Axes, lines: Sequence[Line]) -> None:
    """Write the lines' names to the right of a panel, as high as each line ends as far as the others leave room."""
    figure = panel.figure
    height = 0.8 * float(figure.bbox.height) / figure.dpi  # of the axes, in inches, roughly
    edge: Any = panel.transAxes
    inches = figure.dpi_scale_trans + ScaledTranslation(1.0, 0.0, edge)  # from the right edge on
    beside = blended_transform_factory(inches, panel.transAxes)
    ends = sorted(lines, key=lambda line: line.y[-1])
    low, high = (float(np.log(limit)) for limit in panel.get_ylim())
    wanted = [(float(np.log(line.y[-1])) - low) / (high - low) for line in ends]
    for place, line in zip(spread(wanted, _LABEL_HEIGHT / height), ends, strict=True):
        panel.plot([0.1, 0.34], [place] * 2, transform=beside, clip_on=False, **line.style)
        panel.text(0.4, place, line.name, transform=beside, va="center", color=line.style["color"])


def spread(wanted: Sequence[float], gap: float) -> list[float]:
    """Ascending places as near to the wanted ones as a gap between neighbours allows.

    Neighbours that are too close become a group that is spread about its mean, until no two groups meet.
    """
    groups = [[place] for place in wanted]

    def places(group: Sequence[float]) -> list[float]:
        centre = sum(group) / len(group)
        return [centre + gap * (number - (len(group) - 1) / 2.0) for number in range(len(group))]

    at = 0
    while at < len(groups) - 1:
        if places(groups[at + 1])[0] - places(groups[at])[-1] < gap:
            groups[at : at + 2] = [groups[at] + groups[at + 1]]
            at = max(0, at - 1)
        else:
            at += 1
    return [place for group in groups for place in places(group)]


def count_axis(panel: Axes, words: str) -> None:
    """Name the horizontal axis, on which things are counted, and write its numbers out."""
    panel.set_xlabel(words)
    panel.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:,.0f}"))
