"""Where the best model does not follow the records: what it leaves over that is no noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drillrig_env.calibrate.calibration import Calibration
from drillrig_env.calibrate.records import SPEEDS
from drillrig_env.calibrate.windows import UNITS

_NOISES, _SHARE = 2.0, 0.015
"""Of noise and of a signal's standard deviation, more than both of which is a misfit: speeds that angles were made to
are smooth, and their noise is more than it looks."""


@dataclass(frozen=True)
class Misfit:
    """A signal of a record that the best model does not follow: what it is off by, and the signal's noise."""

    source: str
    signal: str
    left: float  # in the signal's unit
    noise: float

    def __str__(self) -> str:
        unit = UNITS[self.signal]
        return f"{self.source}: the model is off {self.signal} by {self.left:.2g} {unit}, its noise is {self.noise:.2g}"


def misfits(calibration: Calibration) -> list[Misfit]:
    """The signals that the best model does not follow, record by record."""
    found = []
    problem = calibration.best.problem
    for record, windows, left in zip(calibration.records, problem.windows, problem.noise, strict=True):
        swing = np.nanstd(windows.data, axis=(0, 1))
        speeds = [k for k, name in enumerate(windows.names) if name in SPEEDS]
        swing[speeds] = swing[speeds].max(initial=0.0)  # a stiff drive's own speed hardly swings
        for k in np.flatnonzero((left > _NOISES * windows.noise) & (left > _SHARE * swing)):
            found.append(Misfit(record.source, windows.names[k], float(left[k]), float(windows.noise[k])))
    return found


def misfit_words(found: Sequence[Misfit]) -> list[str]:
    """A line for each misfit, and what may be behind them; none where there is none."""
    if not found:
        return []
    why = "its input, a fixed value or the friction's law may be wrong, or the records are of different rigs"
    return [*map(str, found), f"Intervals do not tell of such a misfit: {why}"]
