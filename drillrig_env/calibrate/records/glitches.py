"""Glitches: samples that no rig can have had, found without a model of it, and masked.

A glitch is a jump away and a jump back within 50 ms, or for one sample where these are further apart. Each of its two
jumps is at least four times what 90 % of all steps are, a tenth of the span of the signal (of its middle 98 %), 2.5
times the smallest step, and three times the range of the three samples beside it; and it comes back to less than half
of the jump from where it left. What sticks and slips, steps or only makes noise does none of this: discs have inertia,
so a slip that is sampled four times or more in a period comes and goes over more samples, and the next one is as quick.

Besides, values that loggers write for none (-999.25 and the like) and those that are not finite are masked.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray

_WIDEST = 0.05  # s
_OF_STEPS = 4.0  # times the 90th percentile of the steps
_RESOLVED = 2.5  # times the smallest step, that of the sensor's resolution
_OF_SPAN = 0.1
_BESIDE = 3.0  # times the range of the samples beside a jump
_NEIGHBOURS = 3
_BACK = 0.5  # of the jump
_NONE = (-999.25, -9999.0, -99999.0, -9999.25)  # what loggers write where there is no value
_BEYOND = 1e30


def without_values(signal: FloatArray) -> FloatArray:
    """A signal (n,) as the file has it, NaN where it is not finite, and where the logger means no value."""
    sound = np.isfinite(signal) & (np.abs(signal) < _BEYOND) & ~np.isin(signal, _NONE)
    return np.asarray(np.where(sound, signal, np.nan))


def find_glitches(time: FloatArray, signal: FloatArray) -> npt.NDArray[np.bool_]:
    """Which samples of a signal (n,) at times (n,) in s are glitches; NaN is none."""
    found = np.zeros(len(signal), dtype=bool)
    known = np.flatnonzero(np.isfinite(signal))
    x, t = signal[known], time[known]
    if len(x) < 4 * _NEIGHBOURS:
        return found
    jumps = np.diff(x)
    low, high = np.percentile(x, [1.0, 99.0])
    sizes = np.abs(jumps)
    least = max(
        _OF_STEPS * float(np.percentile(sizes, 90.0)),
        _OF_SPAN * float(high - low),
        _RESOLVED * float(np.min(sizes, where=sizes > 0.0, initial=np.inf)) if np.any(sizes) else 0.0,
    )
    large = np.flatnonzero(sizes > least)
    begin = -1
    for i in large:  # from x[i] to x[i + 1]
        if begin >= 0 and jumps[i] * jumps[begin] < 0.0 and _is_glitch(t, x, begin, int(i)):
            found[known[begin + 1 : i + 1]] = True
            begin = -1
        else:
            begin = int(i)
    return found


def _is_glitch(time: FloatArray, x: FloatArray, begin: int, end: int) -> bool:
    """Whether the samples after `begin` up to `end` lie between a jump away and a jump back."""
    if end > begin + 1 and time[end + 1] - time[begin] > _WIDEST:
        return False
    before, after = x[max(0, begin + 1 - _NEIGHBOURS) : begin + 1], x[end + 1 : end + 1 + _NEIGHBOURS]
    jump = min(abs(x[begin + 1] - x[begin]), abs(x[end + 1] - x[end]))
    calm = max(np.ptp(before), np.ptp(after))
    return bool(jump > _BESIDE * calm and abs(x[end + 1] - x[begin]) < _BACK * jump)
