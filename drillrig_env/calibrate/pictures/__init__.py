"""Pictures of a calibration: what was measured beside the model, what is known how well, and what it means."""

from __future__ import annotations

from drillrig_env.calibrate.pictures.borders import draw_borders
from drillrig_env.calibrate.pictures.parameters import draw_correlations, draw_intervals
from drillrig_env.calibrate.pictures.record import draw_record
from drillrig_env.calibrate.report import Report
from drillrig_env.plots.style import Picture

__all__ = ["draw_all"]


def draw_all(report: Report) -> dict[str, Picture]:
    """Every picture of a report by the name of its file."""
    found: dict[str, Picture] = {}
    if report.borders is not None:
        found["borders"] = draw_borders(report)
    found["intervals"] = draw_intervals(report.calibration)
    if len(report.calibration.unknowns.names) > 1:
        found["correlations"] = draw_correlations(report.calibration)
    for k in range(len(report.calibration.records)):
        found[f"record_{k + 1}"] = draw_record(report, k)
    return found
