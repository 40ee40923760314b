"""The best model beside the records: in the windows that were fitted, and in those that were held out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.calibration import Calibration
from drillrig_env.calibrate.projection import Problem, run_windows
from drillrig_env.calibrate.windows import Windows

FITTED, HELD_OUT = "fitted", "held out"
"""The parts of a record."""


@dataclass(frozen=True, eq=False)
class Beside:
    """The best model in the windows of one part of a record, each from the start that fits it best."""

    record: int  # its place among the records
    part: str
    windows: Windows  # n of them, of m steps
    starts: FloatArray  # (n, FREE)
    shown: FloatArray  # (n, m, channels): what the model shows

    @property
    def residuals(self) -> FloatArray:
        """Model less measured in units of the measured noise, (n, m, channels); NaN where nothing was measured."""
        return np.asarray((self.shown - self.windows.data) / self.windows.noise)


def beside(calibration: Calibration) -> list[Beside]:
    """The model beside every part of every record that has windows.

    Parameters are held. The starts of windows that were held out are found as those of the others are: seven numbers a
    window that nobody knows, without which any comparison would be one of phases.
    """
    best = calibration.best
    found = [
        _beside(calibration, k, FITTED, windows, starts)
        for k, (windows, starts) in enumerate(zip(best.problem.windows, best.problem.starts, strict=True))
    ]
    where = [k for k, windows in enumerate(calibration.held) if len(windows)]
    held = [calibration.held[k] for k in where]
    problem = Problem(held, calibration.unknowns, [best.problem.noise[k] for k in where])
    problem.begin(best.logs)
    problem.residuals(best.logs)
    for k, windows, starts in zip(where, held, problem.starts, strict=True):
        found.append(_beside(calibration, k, HELD_OUT, windows, starts))
    return sorted(found, key=lambda one: one.record)


def _beside(calibration: Calibration, record: int, part: str, windows: Windows, starts: FloatArray) -> Beside:
    states = run_windows(windows, calibration.rig, calibration.friction, starts)
    return Beside(record, part, windows, starts, windows.shown(calibration.rig, states))
