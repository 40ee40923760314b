"""Speeds of encoder angles: slopes over windows that are as long as the steps of the encoder ask for.

An encoder with steps of q rad leaves an error of about q / (W sqrt(n)) in the slope over a window of W seconds with n
samples. The window grows until that is a hundredth of the usual speed, and no further than a twelfth of the period.
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.calibrate.records.glitches import find_glitches
from drillrig_env.calibrate.records.motion import period_of

_ERROR = 0.01  # of the usual speed
_OF_PERIOD = 1.0 / 12.0
_LONGEST = 50  # samples to either side
_ROUNDING = 1e-9  # rad
_STEPS, _WHOLE = 50, 0.1  # moves of so many steps at most tell what a step is; by how much of one they may be off


def speed_of_angle(time: FloatArray, angle: FloatArray) -> tuple[FloatArray, str]:
    """The speed (n,) in rad/s of an angle (n,) in rad at times (n,) in s, NaN where the angle is; and how it was found.

    An angle that is counted within one turn, or from -half a turn to half a turn, goes on past its ends; for that the
    disc may turn by half a turn at most from sample to sample. Glitches are masked first.
    """
    known = np.isfinite(angle)
    t, counted = time[known], angle[known]
    turned = np.unwrap(counted, period=2.0 * pi) if _is_within_one_turn(counted) else counted
    glitches = find_glitches(t, turned)
    known[np.flatnonzero(known)[glitches]] = False
    t, turned = t[~glitches], turned[~glitches]
    step, steps = _step(turned), np.diff(t)
    period = float(np.median(steps))
    half = _half_window(t, turned, step, period)
    slope = _slopes(t, turned, half, (half + 0.5) * period)
    speed = np.full(len(time), np.nan)
    speed[known] = slope
    window = 1e3 * (2 * half + 1) * period
    left = f", steps of {step:.3g} rad leave {_error(step, half, period):.2g} rad/s" if step else ""
    masked = f", {int(glitches.sum())} samples masked as glitches" if np.any(glitches) else ""
    return speed, f"differentiated over windows of {window:.3g} ms{left}{masked}"


def _is_within_one_turn(angle: FloatArray) -> bool:
    return bool(np.ptp(angle) <= 2.0 * pi * (1.0 + 1e-9) and np.abs(np.diff(angle)).max(initial=0.0) > pi)


def _step(angle: FloatArray) -> float:
    """The step of the encoder, rad; 0 where the angle is not in steps that matter."""
    moves = np.abs(np.diff(angle))
    moves = moves[moves > _ROUNDING]
    if len(moves) == 0:
        return 0.0
    step = float(np.median(moves[moves < 1.5 * moves.min()]))
    multiples = moves[moves < (_STEPS + 0.5) * step] / step
    whole = np.abs(multiples - np.round(multiples)) < _WHOLE
    return step if len(multiples) > 0.2 * len(moves) and np.mean(whole) > 0.9 else 0.0


def _half_window(time: FloatArray, angle: FloatArray, step: float, period: float) -> int:
    """How many samples a window has to either side of its middle."""
    usual = float(np.ptp(angle) / (time[-1] - time[0]))
    wanted = next((half for half in range(1, _LONGEST) if _error(step, half, period) <= _ERROR * usual), _LONGEST)
    swing = period_of(time, _slopes(time, angle, wanted, np.inf))
    most = _LONGEST if swing is None else int(0.5 * _OF_PERIOD * swing / period)
    return max(1, min(wanted, most))


def _error(step: float, half: int, period: float) -> float:
    count = 2 * half + 1
    return step / (count * period * sqrt(count))


def _slopes(time: FloatArray, angle: FloatArray, half: int, reach: float) -> FloatArray:
    """The slope of the straight line through the samples within `half` samples and `reach` (s) of each.

    NaN where there is no other sample: windows end at gaps.
    """
    count, t, x, tt, tx = (np.zeros(len(time)) for _ in range(5))
    for offset in range(-half, half + 1):
        inside = slice(max(0, -offset), len(time) - max(0, offset))
        other = slice(max(0, offset), len(time) + min(0, offset))
        apart = time[other] - time[inside]
        near = np.abs(apart) <= reach
        apart, moved = apart * near, (angle[other] - angle[inside]) * near
        count[inside] += near
        t[inside] += apart
        x[inside] += moved
        tt[inside] += apart * apart
        tx[inside] += apart * moved
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((count * tx - t * x) / (count * tt - t * t))
