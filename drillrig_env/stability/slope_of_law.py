"""The speeds at which the slope of friction takes a value, for laws of which it falls and rises again with speed.

The exponential law's slope rises all the way, and is inverted in closed form. That of other laws has extremes between
which it is monotonic, so that each stretch holds one such speed at most. A stretch narrower than 1/17 of its speed is
not seen.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.special import lambertw

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig

_PER_TENFOLD, _SMALLEST, _LARGEST = 40, -6, 4
"""Speeds that are looked at, and powers of ten of 1/v_b from which and up to which."""

_CLOSE = 8.9e-16
"""Share of a speed to which it is found."""


def kinks_of(rig: Rig, friction: Friction) -> list[float]:
    """Speeds (rad/s) above omega_s at which the slope of the law jumps."""
    knee = 1.0 / float(friction.v_b)
    return [knee] if friction.law == "linear" and knee > rig.omega_s else []


def speeds_at_slope(rig: Rig, friction: Friction, slope: float) -> list[float]:
    """All speeds (rad/s) above omega_s at which the slope passes `slope` (N m s/rad) smoothly, rising.

    `friction` is that of one rig, under another law than the exponential one.
    """
    speeds = _stretches(rig, friction)

    def excess(speed: Any) -> FloatArray:
        return np.asarray(friction.slope(rig, speed)) - slope

    return [] if friction.law == "linear" else _roots(excess, speeds)


def last_speed_at_slope(rig: Rig, friction: Friction, slope: float) -> FloatArray:
    """The highest speed (rad/s) at which the slope rises past `slope` (N m s/rad, < 0); 0: it is never so steep.

    One entry a rig for a batch of frictions.
    """
    v_b, spread = np.asarray(friction.v_b, dtype=float), np.asarray(friction.mu_s) - friction.mu_k
    fall = np.asarray(friction.normal_force) * rig.r_1 * spread * v_b
    if friction.law == "linear":
        return np.where(fall > -slope, 1.0 / v_b, 0.0)
    if friction.law == "gaussian":  # -2 u exp(-u^2) fall = slope
        with np.errstate(divide="ignore"):
            argument = -0.5 * (slope / fall) ** 2
        u_squared = -0.5 * lambertw(np.maximum(argument, -np.exp(-1.0)), -1).real
        return np.where(argument > -np.exp(-1.0), np.sqrt(u_squared) / v_b, 0.0)
    last = [max(speeds_at_slope(rig, one, slope), default=0.0) for one in friction.each()]
    return np.reshape(last, np.shape(fall))


def third_derivative(rig: Rig, friction: Friction, speed: float) -> float:
    """Of friction by the bit speed, in N m (s/rad)^3, from differences of its curvature; between kinks."""
    step = 1e-3 / float(friction.v_b)
    near, far = (friction.curvature(rig, speed + np.array([-k, k]) * step) for k in (1.0, 2.0))
    return float((8.0 * np.diff(near)[0] - np.diff(far)[0]) / (12.0 * step))


def _stretches(rig: Rig, friction: Friction) -> FloatArray:
    """Speeds from omega_s on, the extremes of the slope among them."""
    count = (_LARGEST - _SMALLEST) * _PER_TENFOLD + 1
    grid = rig.omega_s + np.logspace(_SMALLEST, _LARGEST, count) / float(friction.v_b)
    speeds = np.concatenate([[rig.omega_s], grid])
    extremes = _roots(lambda speed: np.asarray(friction.curvature(rig, speed)), speeds)
    return np.sort(np.concatenate([speeds, extremes]))


def _roots(function: Callable[[Any], Any], speeds: FloatArray) -> list[float]:
    values = function(speeds)
    changes = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0.0)
    return [float(brentq(function, speeds[i], speeds[i + 1], xtol=_CLOSE * speeds[i], rtol=_CLOSE)) for i in changes]
