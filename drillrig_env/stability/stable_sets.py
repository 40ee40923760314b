"""For which friction slopes, and at which speeds, steady rotation is stable: all of them, as intervals.

Eigenvalues reach the imaginary axis where Z(i omega) + sigma = 0 (`impedance`): at the frequencies where Z(i omega) is
real, for the slope sigma = -Z(i omega). These frequencies are the roots of a polynomial in omega^2, and are found
without rounding, all of them; between two such slopes nothing changes, and Routh's scheme at one slope decides for all.
Most rigs are stable for every slope above one number, Delta T_r,min (4-24); with a drive that shakes by itself, stable
slopes may be a window, several, or none.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from math import isqrt

import numpy as np

from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stability.impedance import Polynomial, impedance_fraction
from drillrig_env.stability.real_roots import positive_roots
from drillrig_env.stability.slope_of_law import kinks_of, last_speed_at_slope, speeds_at_slope


@dataclass(frozen=True)
class Border:
    """A friction slope (N m s/rad) at which steady rotation changes its stability, and the pair's frequency (rad/s)."""

    slope: float
    frequency: float


def stable_slopes(rig: RigLike) -> FloatArray:
    """The friction slopes (N m s/rad) for which steady rotation is stable, as rising open intervals; shape (n, 2).

    No row: none is. The upper end of the last row is infinite where every slope above is stable. Raises
    `FloatingPointError` for a rig whose borders no double can hold.

    >>> from drillrig_env import Rig
    >>> [round(float(slope), 4) for slope in stable_slopes(Rig()).ravel()]  # N m s/rad
    [-0.0128, inf]
    """
    return np.array([[low.slope, high.slope] for low, high in stable_set(Rig.of(rig))]).reshape(-1, 2)


def stable_speeds(rig: RigLike, friction: FrictionLike) -> FloatArray:
    """The speeds (rad/s) at which steady rotation is stable, as rising open intervals; shape (n, 2).

    `rig` and `friction` are given as `Rig.of` and `Friction.of` take them.

    On the law (4-9): most rigs are stable below omega_s, within the stick zone, and above the critical speed. Under a
    law that falls most steeply further up, low speeds above omega_s may be stable too. No row: never. The upper end is
    infinite where every speed above is stable. For a batch of frictions the shape is (rigs, n, 2), with rows of NaN
    behind the intervals of those that have fewer than others.

    >>> from drillrig_env import Friction, Rig, stability
    >>> stability.stable_speeds(Rig(), Friction(20.0)).round(3).tolist()  # rad/s
    [[0.0, 0.001], [2.688, inf]]
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    each = [_stable_speeds(rig, one) for one in friction.each()]
    if np.ndim(friction.break_loose(rig)) == 0:
        return each[0]
    most = max(len(intervals) for intervals in each)
    return np.array([[*intervals, *[[np.nan, np.nan]] * (most - len(intervals))] for intervals in each]).reshape(
        len(each), most, 2
    )


def _stable_speeds(rig: Rig, friction: Friction) -> FloatArray:
    """The intervals of one friction."""
    inside = np.array([[0.0, rig.omega_s]] if is_bearable(rig, float(friction.slope(rig, 0.0))) else []).reshape(-1, 2)
    speeds = [interval for interval in _speeds(rig, friction) if interval[1] > rig.omega_s]
    if len(inside) and speeds and speeds[0][0] <= rig.omega_s:
        return np.array([(0.0, speeds[0][1]), *speeds[1:]])
    return np.array([*inside.tolist(), *((max(low, rig.omega_s), high) for low, high in speeds)]).reshape(-1, 2)


def critical_slope(rig: RigLike) -> float:
    """Delta T_r,min (4-24): the friction slope (N m s/rad) above which steady rotation is stable.

    -0.0128 for the chapter's rig (4-25); infinite where no slope is stable. A slope of friction that rises with speed
    may be too steep all the same: see `stable_slopes`. Raises `ValueError` where there is no such number: where slopes
    that are stable lie below others, of falling friction, that are not.

    >>> from drillrig_env import Friction, Rig, stability
    >>> round(float(stability.critical_slope(Rig())), 4)  # N m s/rad
    -0.0128
    """
    rig = Rig.of(rig)
    intervals = stable_slopes(rig)
    falling = intervals[intervals[:, 0] < 0.0]
    if len(falling) > 1 or np.any(falling[:, 1] < 0.0):
        raise ValueError(
            f"critical_slope: this rig is stable for friction slopes {_words(intervals, 'N m s/rad')}, not above one "
            "number; see stable_slopes"
        )
    return float(intervals[0, 0]) if len(intervals) else np.inf


def critical_fall(rig: Rig, where: str) -> float:
    """`critical_slope` of a rig that is stable under some friction that falls with speed (N m s/rad, negative).

    Raises as that does, and `ValueError` for another rig, in a sentence that begins with `where`.
    """
    slope = critical_slope(rig)
    if slope >= 0.0:
        raise ValueError(
            f"{where}: under any friction that falls with speed steady rotation of this rig is never stable: "
            "its drive shakes by itself; allowed: a rig whose stable_slopes reach below 0"
        )
    return slope


def critical_speed(rig: RigLike, friction: FrictionLike) -> Quantity:
    """omega_c, the Hopf point (rad/s): steady rotation is unstable below and stable above.

    Where the slope of (4-7) equals Delta T_r,min, in closed form; under another law than the exponential one, the
    highest such speed: below it there may be more (see `stable_speeds`). 0 where friction falls so slowly
    that every speed is stable; infinite where no speed is. One entry a rig for a batch of frictions. Raises
    `ValueError` for a friction with which there is no such speed: where it is stable at lower speeds too (see
    `stable_speeds`).

    >>> from drillrig_env import Friction, Rig, stability
    >>> round(float(stability.critical_speed(Rig(), Friction(20.0))), 3)  # rad/s
    2.688
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    at_rest = np.asarray(steepest_fall(rig, friction))
    falling = [interval for interval in stable_slopes(rig) if interval[0] < 0.0]
    above = -falling[-1][0] if falling and falling[-1][1] >= 0.0 else None
    others = falling if above is None else falling[:-1]
    if others and np.any(at_rest > -others[-1][1]):
        one = next(f for f in friction.each() if steepest_fall(rig, f) > -others[-1][1])
        raise ValueError(
            f"critical_speed: with N_1 = {one.normal_force:g} N this rig is stable at speeds "
            f"{_words(np.array(_speeds(rig, one)), 'rad/s')}, not above one number; see stable_speeds"
        )
    if above is None:
        return np.inf if np.ndim(at_rest) == 0 else np.full(at_rest.shape, np.inf)
    if friction.law == "exponential":
        speed = np.log(np.maximum(at_rest / above, 1.0)) / friction.v_b
    else:
        speed = last_speed_at_slope(rig, friction, -above)
    return float(speed) if np.ndim(speed) == 0 else np.asarray(speed)


def is_stable(rig: RigLike, friction: FrictionLike, speed: float) -> bool:
    """Whether steady rotation at `speed` (rad/s) is locally stable; the Hurwitz minors are all positive then.

    `rig` and `friction`, a single one, are given as `Rig.of` and `Friction.of` take them.

    >>> from drillrig_env import Friction, Rig, stability
    >>> [stability.is_stable(Rig(), Friction(20.0), speed) for speed in (2.0, 3.0)]
    [False, True]
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    return is_bearable(rig, float(friction.slope(rig, speed)))


def steepest_fall(rig: Rig, friction: Friction) -> Quantity:
    """Minus the steepest slope (N m s/rad): of (4-7) it is N_1 r_1 (mu_s - mu_k) v_b, towards speed 0."""
    if friction.law != "exponential":
        from drillrig_env.friction.law import steepest_over

        return steepest_over(friction.contacts(rig, 0.0)).reshape(np.shape(friction.break_loose(rig)))
    spread = np.asarray(friction.mu_s) - friction.mu_k
    return np.asarray(np.asarray(friction.normal_force) * rig.r_1 * spread * friction.v_b)


def is_bearable(rig: Rig, slope: float) -> bool:
    """Whether steady rotation is stable at a friction slope (N m s/rad)."""
    intervals = stable_slopes(rig)
    return bool(np.any((intervals[:, 0] < slope) & (slope < intervals[:, 1])))


@lru_cache(maxsize=256)
def stable_set(rig: Rig) -> tuple[tuple[Border, Border], ...]:
    """The stable intervals of slope as pairs of their borders; the upper one at infinity has no frequency (NaN)."""
    fraction = impedance_fraction(rig)
    borders = _borders(rig)
    slopes = [slope for slope, _ in borders]
    between = [(low + high) / 2 for low, high in pairwise(slopes)]
    probes = [*between, slopes[-1] + abs(slopes[-1]) + 1]
    ends = [*(Border(_as_float(rig, slope), frequency) for slope, frequency in borders), Border(np.inf, np.nan)]
    intervals: list[tuple[Border, Border]] = []
    for (low, high), probe in zip(pairwise(ends), probes, strict=True):
        if not low.slope < high.slope or not _is_hurwitz(fraction.characteristic(probe)):
            continue
        if intervals and intervals[-1][1] is low:  # a pair that only touched the axis
            intervals[-1] = (intervals[-1][0], high)
        else:
            intervals.append((low, high))
    return tuple(intervals)


def _borders(rig: Rig) -> list[tuple[Fraction, float]]:
    """Slopes at which eigenvalues lie on the imaginary axis, rising, with their frequency (rad/s).

    With s = i omega, x = omega^2, D = D_e + s D_o and E = E_e + s E_o the imaginary part of Z vanishes where
    D_e E_e + x D_o E_o does. That polynomial ends in -J_1 ..., so it has a root.
    """
    fraction = impedance_fraction(rig)
    (D_e, D_o), (E_e, E_o) = _halves(fraction.D), _halves(fraction.E)
    terms: Polynomial = [Fraction(0)] * 7
    for i, a in enumerate(D_e):
        for j, b in enumerate(E_e):
            terms[i + j] += a * b
    for i, a in enumerate(D_o):
        for j, b in enumerate(E_o):
            terms[i + j + 1] += a * b
    whole = max(value.denominator for value in terms)  # powers of two, all of them
    found = []
    for x in positive_roots([int(value * whole) for value in terms]):
        d_e, d_o, e_e, e_o = (_at(polynomial, x) for polynomial in (D_e, D_o, E_e, E_o))
        found.append(((d_e * e_o - d_o * e_e) / (x * e_o**2 + e_e**2), _root_of(x)))
    return sorted(found)


def _halves(polynomial: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Even and odd part of a polynomial in s = i omega, as polynomials in x = omega^2 = -s^2."""
    even = [(-1) ** (power // 2) * value for power, value in enumerate(polynomial)]
    return even[::2], even[1::2]


def _at(polynomial: Polynomial, x: Fraction) -> Fraction:
    value = Fraction(0)
    for coefficient in reversed(polynomial):
        value = value * x + coefficient
    return value


def _is_hurwitz(polynomial: Polynomial) -> bool:
    """Whether every root of the polynomial lies left of the imaginary axis, by Routh's scheme."""
    upper, lower = polynomial[::-1][::2], polynomial[::-1][1::2]
    if any(value <= 0 for value in polynomial):
        return False
    while lower:
        if lower[0] <= 0:
            return False
        below = [*lower[1:], *([Fraction(0)] * (len(upper) - len(lower)))]
        upper, lower = lower, [a - upper[0] / lower[0] * b for a, b in zip(upper[1:], below, strict=True)]
    return True


def _speeds(rig: Rig, friction: Friction) -> list[tuple[float, float]]:
    """Stable speeds, on the law (4-7) those at which its slope -steepest_fall exp(-v_b omega) is."""
    if friction.law != "exponential":
        return _speeds_of_other_law(rig, friction)
    at_rest, v_b = float(steepest_fall(rig, friction)), float(friction.v_b)
    found = []
    for low, high in stable_slopes(rig):
        if low < 0.0 < at_rest and -at_rest < high:
            slowest = np.log(max(at_rest / -low, 1.0)) / v_b
            found.append((float(slowest), np.inf if high >= 0.0 else float(np.log(at_rest / -high) / v_b)))
        elif at_rest == 0.0 and low < 0.0 < high:
            found.append((0.0, np.inf))
    return sorted(found)


def _speeds_of_other_law(rig: Rig, friction: Friction) -> list[tuple[float, float]]:
    """Stable speeds from omega_s on, where the slope may take one value at several speeds."""
    borders = {slope for slope in stable_slopes(rig).ravel().tolist() if np.isfinite(slope)}
    passed = [speed for slope in borders for speed in speeds_at_slope(rig, friction, slope)]
    ends = [rig.omega_s, *sorted({*passed, *kinks_of(rig, friction)}), np.inf]
    found: list[tuple[float, float]] = []
    for low, high in pairwise(ends):
        if is_bearable(rig, float(friction.slope(rig, 0.5 * (low + high) if np.isfinite(high) else 2.0 * low))):
            joins = bool(found) and found[-1][1] == low
            found[-1:] = [(found[-1][0], high)] if joins else [*found[-1:], (low, high)]
    return found


def _words(intervals: FloatArray, unit: str) -> str:
    parts = [f"above {low:.6g}" if np.isinf(high) else f"from {low:.6g} to {high:.6g}" for low, high in intervals]
    return f"{' and '.join(parts)} {unit}"


def _root_of(x: Fraction) -> float:
    """Square root, to the last bit of a double."""
    shift = max(0, 128 - x.numerator.bit_length() + x.denominator.bit_length())
    shift += shift % 2
    return float(Fraction(isqrt((x.numerator << shift) // x.denominator), 1 << (shift // 2)))


def _as_float(rig: Rig, slope: Fraction) -> float:
    try:
        value = float(slope)
    except OverflowError:
        value = np.inf
    if not np.isfinite(value) or (value == 0.0 and slope != 0):
        raise FloatingPointError(
            "stable_slopes: a border of stability that no double can hold; check the rig's parameters"
        )
    return value
