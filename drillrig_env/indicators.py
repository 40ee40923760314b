"""How well a model matches a measurement: the chapter's indicators P_C (4-10) and APL (4-11).

Table 4.2 applies both to the bit speed of the chapter's rig: P_C between 0.893 and 0.955, APL between
0.010 and 0.172. P_C sees the shape and is blind to scale and offset; APL sees only the two maxima.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan, nan

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.parameters import refuse

CHAPTER_WINDOW = 10.0
"""Seconds from the start of a measurement over which the chapter takes P_C."""

_ROUNDING = 1e-9  # a spread below this share of the largest value is rounding: no rig is measured so finely
_TIME_TOLERANCE = 1e-9  # s; times closer than this are the same time


class UndefinedIndicatorError(ValueError):
    """The signals are sound, but the indicator divides by zero for them."""


@dataclass(frozen=True)
class Score:
    """How one signal of the model matches the measured one over one part of the measurement.

    `signal` and `part` say of what, `samples` how many there are; `correlation` is P_C, and `amplitude_pulse_level` is
    APL.

    An indicator that is undefined for the signals is nan.
    """

    signal: str
    part: str  # such as "first 10 s"
    samples: int
    correlation: float  # P_C (4-10)
    amplitude_pulse_level: float  # APL (4-11)


def correlation(measured: npt.ArrayLike, simulated: npt.ArrayLike) -> float:
    """Pearson correlation coefficient P_C of two signals of shape (n,), equation (4-10).

    X_2 is `simulated`.

        P_C = (S_12 - S_1 S_2 / n) / sqrt((S_11 - S_1^2 / n) (S_22 - S_2^2 / n))

    with S_1 the sum over X_1 (measured), S_12 that over X_1 X_2, and so on. 1 is a perfect match, 0
    none, -1 the mirror image. The chapter prints sums from i = 0 to n and divides by n, "the number of
    points": n points are meant, or P_C would depend on the offset. It applies P_C to the first 10 s
    only, `CHAPTER_WINDOW`; here the caller chooses what to pass.

    >>> round(correlation([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 1.0, 3.0]), 3)
    0.8

    Raises `ValueError` for signals of unequal lengths, with fewer than 2 points or with a number that is
    not finite, and its subclass `UndefinedIndicatorError` for a constant signal.
    """
    x_1, x_2 = _pair("correlation", measured, simulated)
    for name, x in (("measured", x_1), ("simulated", x_2)):
        if np.ptp(x) <= _ROUNDING * np.abs(x).max():
            raise UndefinedIndicatorError(
                f"correlation: the {name} signal is constant, {x[0]:g} at all {len(x)} points: P_C is undefined"
            )
    return float(np.corrcoef(x_1, x_2)[0, 1])


def amplitude_pulse_level(measured: npt.ArrayLike, simulated: npt.ArrayLike) -> float:
    """Amplitude pulse level APL of two signals of shape (n,), equation (4-11); 0 is a perfect match.

        APL = |max(X_1) - max(X_2)| / |max(X_1)|

    with X_1 measured and X_2 simulated.

    >>> amplitude_pulse_level([0.0, 4.0, 1.0], [0.0, 1.0, 5.0])
    0.25

    Raises `ValueError` as `correlation` does, and `UndefinedIndicatorError` where max(measured) is 0.
    """
    x_1, x_2 = _pair("amplitude_pulse_level", measured, simulated)
    if x_1.max() == 0.0:
        raise UndefinedIndicatorError("amplitude_pulse_level: max(measured) is 0: APL is undefined")
    return float(abs(x_1.max() - x_2.max()) / abs(x_1.max()))


def score_signals(
    time: FloatArray,
    measured: Mapping[str, FloatArray],
    simulated: Mapping[str, FloatArray],
    window: float = CHAPTER_WINDOW,
) -> list[Score]:
    """Both indicators for every signal of `measured`: over the times up to `window` (s), then over all.

    `simulated` has those of the model under the same names.

    All signals have the shape (n,) of `time` (s, ascending from about 0). Raises `ValueError` for a
    window that holds fewer than 2 samples, and for signals that `correlation` does not allow.

    >>> import numpy as np
    >>> time = np.arange(0.0, 20.0, 0.1)
    >>> measured, simulated = {"bit_speed": 1 + np.sin(time)}, {"bit_speed": 1 + 0.9 * np.sin(time - 0.1)}
    >>> print(score_table(score_signals(time, measured, simulated)))
    signal        part            samples        P_C        APL
    bit_speed     first 10 s          101      0.994      0.050
    bit_speed     whole file          200      0.995      0.050
    """
    early = time <= window + _TIME_TOLERANCE
    if np.count_nonzero(early) < 2:
        raise refuse("score_signals", "window", window, "s", f">= {time[1]:g}")
    parts = {f"first {window:g} s": early, "whole file": np.ones(len(time), dtype=bool)}
    return [
        Score(
            signal=name,
            part=part,
            samples=int(np.count_nonzero(chosen)),
            correlation=_or_nan(correlation, x_1[chosen], simulated[name][chosen]),
            amplitude_pulse_level=_or_nan(amplitude_pulse_level, x_1[chosen], simulated[name][chosen]),
        )
        for name, x_1 in measured.items()
        for part, chosen in parts.items()
    ]


def score_table(scores: Sequence[Score]) -> str:
    """Scores as a table for the terminal, a line each. `scores` are those of `score_signals`."""
    lines = [f"{'signal':14}{'part':14}{'samples':>9}{'P_C':>11}{'APL':>11}"]
    for score in scores:
        indicators = (score.correlation, score.amplitude_pulse_level)
        cells = ("undefined" if isnan(value) else f"{value:.3f}" for value in indicators)
        lines.append(f"{score.signal:14}{score.part:14}{score.samples:9}" + "".join(f"{cell:>11}" for cell in cells))
    if any("undefined" in line for line in lines):
        lines.append("undefined: P_C of a signal that is constant, APL of a measured maximum of 0")
    return "\n".join(lines)


def _or_nan(indicator: Callable[[FloatArray, FloatArray], float], x_1: FloatArray, x_2: FloatArray) -> float:
    try:
        return indicator(x_1, x_2)
    except UndefinedIndicatorError:
        return nan


def _pair(where: str, measured: npt.ArrayLike, simulated: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    x_1, x_2 = np.asarray(measured, dtype=float), np.asarray(simulated, dtype=float)
    if x_1.ndim != 1 or x_1.shape != x_2.shape or len(x_1) < 2:
        raise ValueError(
            f"{where}: signals of shapes {x_1.shape} and {x_2.shape} are not allowed; "
            "allowed: (n,) with n >= 2, the same for both"
        )
    for name, x in (("measured", x_1), ("simulated", x_2)):
        if not np.all(finite := np.isfinite(x)):
            at = int(np.argmin(finite))
            raise ValueError(f"{where}: {name}[{at}] = {x[at]} is not allowed; allowed: finite numbers")
    return x_1, x_2
