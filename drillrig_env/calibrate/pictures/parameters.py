"""How well each parameter is known, and how what is known of one hangs together with the others."""

from __future__ import annotations

import numpy as np

from drillrig_env.calibrate.calibration import AT_BOUND, BY_RECORDS, NOT_BY_RECORDS, Calibration
from drillrig_env.plots.style import BLUE, GREY, VERMILLION, Picture, look, new_figure

_WORTH_SAYING = 0.3
"""A correlation above this is written as a number."""


def draw_intervals(calibration: Calibration) -> Picture:
    """How far the 90 % interval of each parameter goes from its value, beside what was known beforehand."""
    rows = calibration.rows()[::-1]
    beforehand = calibration.unknowns.deviations[::-1]
    colours = {BY_RECORDS: BLUE, NOT_BY_RECORDS: GREY, AT_BOUND: VERMILLION}
    with look():
        figure = new_figure(0.9 + 0.19 * len(rows))
        axes = figure.subplots()
        for k, ((_, value, _, high, told), before) in enumerate(zip(rows, beforehand, strict=True)):
            known = 100.0 * (high / value - 1.0)
            axes.plot(known, k, "o", color=colours[told], ms=4.5)
            axes.plot(100.0 * np.expm1(1.645 * before), k, "|", color="0.6", ms=8)
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.set_yticks(range(len(rows)), [row[0] for row in rows])
        axes.set_ylim(-0.6, len(rows) - 0.4)
        axes.set_xlabel("upper end of the 90 % interval above the value, %")
        for told, colour in colours.items():
            if any(row[4] == told for row in rows):
                axes.plot([], [], "o", color=colour, ms=4.5, label=told)
        axes.plot([], [], "|", color="0.6", ms=8, label="beforehand")
        figure.legend(loc="outside upper right", ncols=4)
    return Picture(figure, "How well each parameter is known.")


def draw_correlations(calibration: Calibration) -> Picture:
    """The correlations of the logarithms of the parameters."""
    names = calibration.unknowns.names
    deviations = calibration.spread.deviations
    table = calibration.spread.covariance / np.outer(deviations, deviations)
    count = len(names)
    with look():
        figure = new_figure(1.2 + 0.26 * count)
        axes = figure.subplots()
        hidden = np.triu(np.ones((count, count), dtype=bool))
        image = axes.imshow(np.ma.masked_array(table, hidden), cmap="RdBu_r", vmin=-1.0, vmax=1.0, aspect="auto")
        for i in range(count):
            for k in range(i):
                if abs(table[i, k]) >= _WORTH_SAYING:
                    colour = "white" if abs(table[i, k]) > 0.6 else "black"
                    axes.text(
                        k,
                        i,
                        f"{table[i, k]:.2f}".replace("0.", "."),
                        ha="center",
                        va="center",
                        fontsize=6,
                        color=colour,
                    )
        axes.set_xticks(range(count - 1), names[:-1], rotation=60, ha="right", rotation_mode="anchor")
        axes.set_yticks(range(1, count), names[1:])
        axes.set_xlim(-0.5, count - 1.5)
        axes.set_ylim(count - 0.5, 0.5)
        axes.grid(visible=False)
        figure.colorbar(image, label="correlation", shrink=0.6)
    return Picture(
        figure,
        "Correlations of what is known of the parameters: of a pair near 1 or -1 the records tell the ratio or the "
        "product better than either. Draw rigs from draws.npz, not each parameter by itself.",
    )
