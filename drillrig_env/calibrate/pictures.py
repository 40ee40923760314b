"""Pictures of a calibration: what was measured beside the model, and how well each parameter is known."""

from __future__ import annotations

from drillrig_env.calibrate.calibration import BY_RECORDS, Calibration
from drillrig_env.calibrate.projection import run_windows
from drillrig_env.calibrate.windows import UNITS
from drillrig_env.plots.style import BLUE, DARK, GREY, TIME, VERMILLION, Picture, look, new_figure

_SHOWN = 6
"""Windows of a record that are shown."""


def draw_record(calibration: Calibration, number: int) -> Picture:
    """The first windows of a record, measured and by the model, a panel for each signal."""
    best = calibration.best
    windows, starts = best.problem.windows[number], best.problem.starts[number]
    shown = windows.shown(calibration.rig, run_windows(windows, calibration.rig, calibration.friction, starts))
    count = min(_SHOWN, len(windows))
    steps = windows.data.shape[1]
    time = windows.times[:count].ravel()
    with look():
        figure = new_figure(0.6 + 1.3 * len(windows.names))
        panels = figure.subplots(len(windows.names), 1, sharex=True, squeeze=False)[:, 0]
        for i, (axes, name) in enumerate(zip(panels, windows.names, strict=True)):
            model = shown[:count, :, i].copy()
            axes.plot(time, windows.data[:count, :, i].ravel(), color=GREY, lw=0.8, label="measured")
            for k in range(count):
                part = slice(k * steps, (k + 1) * steps)
                axes.plot(time[part], model[k], color=VERMILLION, lw=1.0, label="model" if k == 0 else None)
            axes.set_ylabel(f"{name.replace('_', ' ')},\n{UNITS[name]}")
        panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0, ncols=2)
        panels[-1].set_xlabel(TIME)
        panels[-1].set_xlim(windows.times[0, 0] - windows.lengths[0, 0], time[-1])
    source = calibration.records[number].source
    return Picture(figure, f"{source}: the first {count} windows, each with a start of its own.")


def draw_intervals(calibration: Calibration) -> Picture:
    """The 90 % interval of each parameter, as a share of its value."""
    rows = calibration.rows()[::-1]
    with look():
        figure = new_figure(0.8 + 0.2 * len(rows))
        axes = figure.subplots()
        for k, (_, value, low, high, told) in enumerate(rows):
            colour = BLUE if told == BY_RECORDS else GREY
            ends = [100.0 * (low / value - 1.0), 100.0 * (high / value - 1.0)]
            axes.plot(ends, [k, k], color=colour, lw=2.0, solid_capstyle="butt")
            axes.plot(0.0, k, "o", color=DARK, ms=3)
        axes.set_yticks(range(len(rows)), [row[0] for row in rows])
        axes.set_xlabel("90 % interval, % of the value")
    return Picture(figure, "How well the records tell each parameter; grey: not determined by them.")
