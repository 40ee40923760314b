"""A record beside the model: some of its windows, with bands of what the rig may be, and what is left over."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.ticker import MaxNLocator

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.beside import HELD_OUT, Beside
from drillrig_env.calibrate.calibration import Calibration
from drillrig_env.calibrate.projection import FREE, Problem, run_windows
from drillrig_env.calibrate.report import Report
from drillrig_env.calibrate.windows import UNITS, Windows
from drillrig_env.plots.style import BLUE, DARK, GREY, TIME, VERMILLION, Picture, look, new_figure
from drillrig_env.stepper.finite import NotFiniteError

_SHOWN, _DRAWS = 6, 16
"""Windows of a record that are shown, and rigs drawn for the bands."""

_LEAST, _MOST = 3.0, 12.0
"""How far the axes of residuals reach, in units of the noise."""


def draw_record(report: Report, number: int) -> Picture:
    """The windows of a record that swing most, one after another: measured, the model, and model less measured."""
    calibration = report.calibration
    parts = [one for one in report.parts if one.record == number]
    windows, starts, held = _shown(parts)
    best = windows.shown(calibration.rig, run_windows(windows, calibration.rig, calibration.friction, starts))
    low, high = _band(calibration, windows, number)
    left = (best - windows.data) / windows.noise
    time = windows.times
    with look():
        count = len(windows.names)
        figure = new_figure(0.7 + 1.75 * count)
        panels = figure.subplots(2 * count, 1, sharex=True, height_ratios=[2.6, 1.0] * count)
        for i, name in enumerate(windows.names):
            values, residuals = panels[2 * i], panels[2 * i + 1]
            for k in range(len(windows)):
                for axes in (values, residuals):
                    if held[k]:
                        ends = time[k, 0] - windows.lengths[k, 0], time[k, -1]
                        axes.axvspan(*ends, color="0.92", lw=0.0, zorder=0, label="held out")
                values.plot(time[k], windows.data[k, :, i], ".", color=GREY, ms=1.5, label="measured")
                values.plot(time[k], best[k, :, i], color=VERMILLION, lw=0.9, label="model")
                residuals.plot(time[k], left[k, :, i], color=BLUE, lw=0.5)
                for axes, centre, unit in ((values, 0.0, 1.0), (residuals, best[k, :, i], windows.noise[i])):
                    ends = (low[k, :, i] - centre) / unit, (high[k, :, i] - centre) / unit
                    axes.fill_between(time[k], *ends, color=VERMILLION, alpha=0.4, lw=0.0, label="rigs drawn")
            sizes = np.abs(left[:, :, i][np.isfinite(left[:, :, i])])
            reach = float(np.clip(np.quantile(sizes, 0.995), _LEAST, _MOST)) if len(sizes) else _LEAST
            residuals.set_ylim(-1.15 * reach, 1.15 * reach)
            residuals.axhline(0.0, color=DARK, lw=0.5)
            residuals.yaxis.set_major_locator(MaxNLocator(3, integer=True, symmetric=True))
            values.set_ylabel(f"{name.replace('_', ' ')},\n{UNITS[name]}")
            residuals.set_ylabel("residual\n/ noise")
        handles, labels = panels[0].get_legend_handles_labels()
        known = dict(zip(labels, handles, strict=True))
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.0}
        panels[0].legend(known.values(), known, ncols=4, markerscale=4, **place)
        panels[-1].set_xlabel(TIME)
        panels[-1].set_xlim(time[0, 0] - windows.lengths[0, 0], time[-1, -1])
        figure.align_ylabels(panels)
    return Picture(figure, _caption(report, number, windows, held))


def _caption(report: Report, number: int, windows: Windows, held: Sequence[bool]) -> str:
    noise = ", ".join(
        f"{size:.2g} {UNITS[name]} of {name.replace('_', ' ')}"
        for name, size in zip(windows.names, windows.noise, strict=True)
    )
    kept = "Shaded windows were held out of the fit. " if any(held) else ""
    return (
        f"{report.calibration.records[number].source}: {len(windows)} windows of {len(windows.whole or windows)}, the "
        f"stretch that swings most, each with a start of its own. {kept}Bands: 5 to 95 % of {_DRAWS} rigs that the "
        f"records allow. Residual: model less measured in units of the noise, {noise}."
    )


def _shown(parts: Sequence[Beside]) -> tuple[Windows, FloatArray, list[bool]]:
    """Windows of a record that follow one another, where each begins, and whether it was held out of the fit.

    They are those that swing most, one that was held out among them where there is any.
    """
    some = parts[0].windows
    whole = some if some.whole is None else some.whole
    starts, held = np.zeros((len(whole), FREE)), np.zeros(len(whole), dtype=bool)
    for one in parts:
        places = np.arange(len(whole)) if one.windows.places is None else one.windows.places
        starts[places], held[places] = one.starts, one.part == HELD_OUT
    count = min(_SHOWN, len(whole))
    values = np.ma.masked_invalid(whole.data / whole.noise)
    swings = np.ma.filled(values.std(axis=1), 0.0).sum(axis=1)
    firsts = range(len(whole) - count + 1)
    allowed = [k for k in firsts if held[k : k + count].any()] or firsts
    first = max(allowed, key=lambda k: float(swings[k : k + count].sum()))
    shown = np.arange(first, first + count)
    return whole.take(shown), starts[shown], held[shown].tolist()


def _band(calibration: Calibration, windows: Windows, number: int) -> tuple[FloatArray, FloatArray]:
    """Between which values the signals of 90 % of the rigs drawn lie, each at its own best starts."""
    problem = Problem([windows], calibration.unknowns, [calibration.best.problem.noise[number]])
    found = []
    for logs in calibration.draws[:_DRAWS]:
        try:
            problem.begin(logs)
            problem.residuals(logs)
            rig, friction = calibration.unknowns.at(logs)
            found.append(windows.shown(rig, run_windows(windows, rig, friction, problem.starts[0])))
        except NotFiniteError:  # what nothing is known of may run away
            continue
    if not found:
        return np.full_like(windows.data, np.nan), np.full_like(windows.data, np.nan)
    low, high = np.quantile(found, [0.05, 0.95], axis=0)
    return low, high
