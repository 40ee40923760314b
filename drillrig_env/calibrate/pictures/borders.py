"""What the calibrated rig does over speed reference and normal force, and how well that is known."""

from __future__ import annotations

import numpy as np

from drillrig_env.calibrate.meaning import SPEEDS, band
from drillrig_env.calibrate.report import Report
from drillrig_env.plots.style import DARK, GREEN, SPEED_REFERENCE, VERMILLION, Picture, look, new_figure


def draw_borders(report: Report) -> Picture:
    """Critical speed and end of stick-slip over the normal force, each with the band of what the rig may be."""
    borders = report.borders
    assert borders is not None  # a report of records without load has none
    forces = borders.normal_force
    speeds = np.where(np.isfinite(borders.best), borders.best, np.nan)
    bands = [band(borders.draws[:, i]) for i in range(len(SPEEDS))]
    reach = 1.25 * float(
        np.nanmax([*speeds.ravel(), *(np.nanmax(one, initial=0.0) for one in map(_finite, bands)), 1e-9])
    )
    with look():
        figure = new_figure(3.4)
        axes = figure.subplots()
        critical, end = np.nan_to_num(speeds, nan=0.0)
        axes.fill_betweenx(forces, 0.0, critical, color=VERMILLION, alpha=0.12, lw=0.0, label="stick-slip only")
        both = end > critical
        axes.fill_betweenx(
            forces, critical, end, where=both, fc=GREEN, alpha=0.14, hatch="//", ec="0.6", lw=0.0, label="bistable"
        )
        for speed, (low, high), style, name in zip(speeds, bands, ("-", "-."), SPEEDS, strict=True):
            axes.fill_betweenx(forces, low, high, color=DARK, alpha=0.3, lw=0.0)
            axes.plot(speed, forces, color=DARK, lw=1.2, ls=style, marker=".", label=name, clip_on=False)
        axes.set_xlim(0.0, reach)
        axes.set_ylim(0.0, forces[-1])
        axes.set_xlabel(SPEED_REFERENCE)
        axes.set_ylabel(r"normal force $N_1$, N")
        figure.legend(loc="outside upper center", ncols=4)
    return Picture(figure, _caption(report))


def _finite(values: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(values), values, 0.0)


def _caption(report: Report) -> str:
    borders = report.borders
    assert borders is not None
    open_ones = [one.name for one in report.means if not one.determined]
    told = f" At the largest load, not determined by these records: {', '.join(open_ones)}." if open_ones else ""
    return (
        "Where the best rig sticks and slips, where it does so or rotates steadily as it was left, and where it only "
        f"rotates; dark bands: 5 to 95 % of {len(borders.draws)} rigs that the records allow. Up to "
        f"{borders.normal_force[-1]:.4g} N, the largest load of the records.{told}"
    )
