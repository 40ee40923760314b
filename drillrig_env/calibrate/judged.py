"""How well a calibration follows each signal: P_C (4-10) and APL (4-11) after alignment, fitted and held out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import nan

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.beside import Beside
from drillrig_env.calibrate.calibration import Calibration
from drillrig_env.indicators import UndefinedIndicatorError, amplitude_pulse_level, correlation

_MOVES = 3.0
"""A signal whose standard deviation is below so many times its noise is steady: P_C would be one of noise."""

HEADINGS = ["record", "windows", "signal", "P_C", "APL", "residual / noise"]


@dataclass(frozen=True)
class Judged:
    """How well the best model follows a signal in the windows of a part of a record; NaN where a score has no sense."""

    source: str
    part: str
    windows: int
    signal: str
    correlation: float  # P_C (4-10), over all windows together
    amplitude_pulse_level: float  # APL (4-11), likewise
    off: float  # root mean square of model less measured, in units of the measured noise


def judged(calibration: Calibration, parts: Sequence[Beside]) -> list[Judged]:
    """A row for each signal that is measured in a part of a record."""
    found = []
    for one in parts:
        for i, name in enumerate(one.windows.names):
            held = np.isfinite(one.windows.data[:, :, i])
            if np.count_nonzero(held) < 2:
                continue
            measured, model = one.windows.data[:, :, i][held], one.shown[:, :, i][held]
            moves = np.std(measured) > _MOVES * one.windows.noise[i]
            found.append(
                Judged(
                    calibration.records[one.record].source,
                    one.part,
                    len(one.windows),
                    name,
                    _or_nan(correlation, measured, model) if moves else nan,
                    _or_nan(amplitude_pulse_level, measured, model),
                    float(np.sqrt(np.mean(one.residuals[:, :, i][held] ** 2))),
                )
            )
    return found


def judged_rows(found: Sequence[Judged]) -> list[list[str]]:
    """A row of text for each, under `HEADINGS`."""
    return [
        [
            one.source,
            f"{one.windows} {one.part}",
            one.signal.replace("_", " "),
            _number(one.correlation),
            _number(one.amplitude_pulse_level),
            f"{one.off:.2f}",
        ]
        for one in found
    ]


def _number(value: float) -> str:
    return f"{value:.3f}" if np.isfinite(value) else "-"


def _or_nan(indicator: Callable[[FloatArray, FloatArray], float], measured: FloatArray, model: FloatArray) -> float:
    try:
        return indicator(measured, model)
    except UndefinedIndicatorError:
        return nan
