"""Where the best model does not follow the records: what it leaves over that is no noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drillrig_env.calibrate.beside import Beside
from drillrig_env.calibrate.calibration import Calibration
from drillrig_env.calibrate.records import SPEEDS
from drillrig_env.calibrate.windows import UNITS

_NOISES, _SHARE = 1.5, 0.015
"""Of noise and of a signal's standard deviation, more than both of which is a misfit: speeds that angles were made to
are smooth, and their noise is more than it looks."""


@dataclass(frozen=True)
class Misfit:
    """A signal of a record that the best model does not follow: what it is off by, and the signal's noise."""

    source: str
    signal: str
    left: float  # root mean square, in the signal's unit
    noise: float

    def __str__(self) -> str:
        unit = UNITS[self.signal]
        return f"{self.source}: the model is off {self.signal} by {self.left:.2g} {unit}, its noise is {self.noise:.2g}"


def misfits(calibration: Calibration, parts: Sequence[Beside]) -> list[Misfit]:
    """The signals that the best model does not follow, record by record, in all windows, fitted and held out.

    What it is off by is the root mean square of what is left over. The fit is soft to large residuals and may pass over
    what a motor does in the moments after a step, as if these were glitches: here they count in full.
    """
    found = []
    for number, record in enumerate(calibration.records):
        here = [one for one in parts if one.record == number]
        names, noise = here[0].windows.names, here[0].windows.noise
        left, swing = np.zeros(len(names)), np.zeros(len(names))
        for i in range(len(names)):
            measured = np.concatenate([one.windows.data[:, :, i].ravel() for one in here])
            residuals = np.concatenate([one.residuals[:, :, i].ravel() for one in here])
            if (held := np.isfinite(measured)).any():
                left[i] = noise[i] * np.sqrt(np.mean(residuals[held] ** 2))
                swing[i] = np.std(measured[held])
        speeds = [k for k, name in enumerate(names) if name in SPEEDS]
        swing[speeds] = swing[speeds].max(initial=0.0)  # a stiff drive's own speed hardly swings
        for k in np.flatnonzero((left > _NOISES * noise) & (left > _SHARE * swing)):
            found.append(Misfit(record.source, names[k], float(left[k]), float(noise[k])))
    return found


def misfit_words(found: Sequence[Misfit]) -> list[str]:
    """A line for each misfit, and what may be behind them; none where there is none."""
    if not found:
        return []
    why = (
        "an input, a fixed value or the friction's law may be wrong, the records may be of different rigs, or the fit "
    )
    how = "may have ended beside the best one: try more --starts, or another --seed"
    return [*map(str, found), f"Intervals do not tell of such a misfit: {why}{how}"]
