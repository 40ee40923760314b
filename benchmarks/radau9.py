"""An independent compiled solution of the state equations, for rigs that SciPy needs minutes for.

Radau IIA with five stages (order 9; Hairer & Wanner, Solving Ordinary Differential Equations II, section IV.5) on one
piece of the friction law (4-9) at a time, each kink located by the length of the step that ends on it. A step is kept
where it agrees with two of half its length. It shares nothing with the fast stepper but the numbers of a rig: the
equations are written here once more, from the chapter, and no exponential is taken.
"""

from __future__ import annotations

from math import exp

import numpy as np
from numpy.polynomial import legendre

from drillrig_env import Friction, Rig
from drillrig_env.arrays import FloatArray
from drillrig_env.jit.compiled import compiled

_STAGES = 5
_LONGEST, _LEVELS = 0.05, 50
"""The longest step (s), and how often it may be halved."""

_FIRST_LEVEL, _AFTER_KINK = 8, 4
"""How often the first step is halved, and how often more the one after a kink."""

_LOOKS = 24
"""Places within a step where the bit speed is looked at for a kink."""


def _coefficients() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Nodes and matrix of Radau IIA, and the polynomial through 0 and the nodes at `_LOOKS` equal distances."""
    roots = np.sort(legendre.legroots([0.0] * (_STAGES - 1) + [-1.0, 1.0]).real)
    roots[-1] = 1.0
    nodes = (roots + 1.0) / 2.0
    powers = np.linalg.inv(np.vander(nodes, increasing=True))
    order = np.arange(1, _STAGES + 1)
    matrix = (nodes[:, None] ** order / order) @ powers
    with_start = np.linalg.inv(np.vander(np.append(0.0, nodes), increasing=True))
    looks = np.vander(np.arange(1, _LOOKS + 1) / _LOOKS, _STAGES + 1, increasing=True) @ with_start
    return nodes, matrix, np.ascontiguousarray(looks)


_NODES, _MATRIX, _AT_LOOKS = _coefficients()


def solve(
    rig: Rig,
    friction: Friction,
    state: FloatArray,
    speed_reference: float,
    period: float,
    samples: int,
    tolerance: float = 1e-11,
) -> FloatArray:
    """States of shape (samples + 1, 7) every `period` (s) from `state` at constant speed reference (rad/s).

    `tolerance` is what a step and its halves may differ by, as a share of the largest state of its kind so far, or of
    1. T_r2 is constant, as for a disc 2 that turns forwards. Raises `ArithmeticError` where no step is short enough.
    """
    p, (normal_force, mu_s, mu_k, v_b) = rig, friction.as_array()[0].tolist()
    A, constant = np.zeros((7, 7)), np.zeros(7)
    A[0, 2:4], A[1, 3:5], A[6, 4] = (1.0, -1.0), (1.0, -1.0), -1.0
    A[2] = np.array([-p.k_1, 0.0, -p.d_1 - p.C_1, p.d_1, 0.0, 0.0, 0.0]) / p.J_1
    A[3] = np.array([p.k_1, -p.k_2, p.d_1, -p.d_1 - p.d_2 - p.C_2, p.d_2, 0.0, 0.0]) / p.J_2
    A[4] = np.array([0.0, p.k_2, 0.0, p.d_2, -p.d_2 - p.eta**2 * p.C_m, p.eta * p.K_T, 0.0]) / p.J_3
    A[5] = np.array([0.0, 0.0, 0.0, 0.0, -p.eta * p.K_E - p.k_p, -p.R, p.k_i]) / p.L
    constant[3], constant[4] = -p.T_r2 / p.J_2, -p.eta * p.T_f / p.J_3
    constant[5], constant[6] = p.k_p * speed_reference / p.L, speed_reference
    law = np.array([normal_force * p.r_1 * mu_s, normal_force * p.r_1 * mu_k, v_b, p.omega_s, p.J_1])
    states = np.empty((samples + 1, 7))
    states[0] = state
    if not _solve(states, A, constant, law, period, tolerance):
        raise ArithmeticError("no step is short enough")
    return states


@compiled
def _torque(zone: int, speed: float, law: FloatArray) -> tuple[float, float]:
    static, kinetic, v_b, omega_s, _ = law
    if zone == 0:
        return static * speed / omega_s, static / omega_s
    falling = (static - kinetic) * exp(-v_b * zone * speed)
    return zone * (kinetic + falling), -v_b * falling


@compiled
def _prepare(A: FloatArray, constant: FloatArray, J_1: float, step: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A step as stages = from_start @ y + from_constant + from_torque @ T, in increments about y; all linear parts."""
    n = 7 * _STAGES
    system, input_ = np.zeros((n, n)), np.zeros((n, 8 + _STAGES))
    for i in range(_STAGES):
        for j in range(_STAGES):
            for a in range(7):
                for b in range(7):
                    system[7 * i + a, 7 * j + b] = -step * _MATRIX[i, j] * A[a, b]
                    input_[7 * i + a, b] += step * _MATRIX[i, j] * A[a, b]
                input_[7 * i + a, 7] += step * _MATRIX[i, j] * constant[a]
            input_[7 * i + 2, 8 + j] = -step * _MATRIX[i, j] / J_1
    for i in range(n):
        system[i, i] += 1.0
    full = np.linalg.solve(system, input_)
    return np.ascontiguousarray(full[:, :7]), np.ascontiguousarray(full[:, 7]), np.ascontiguousarray(full[:, 8:])


@compiled
def _stages(
    y: FloatArray,
    zone: int,
    law: FloatArray,
    from_start: FloatArray,
    from_constant: FloatArray,
    from_torque: FloatArray,
    increments: FloatArray,
) -> bool:
    """Newton's method for the bit speed at the stages; the increments of all states there."""
    linear = from_start @ y + from_constant
    speed, torque, residual = np.full(_STAGES, y[2]), np.empty(_STAGES), np.empty(_STAGES)
    system = np.empty((_STAGES, _STAGES))
    last = np.inf
    for turn in range(25):
        for j in range(_STAGES):
            torque[j], slope = _torque(zone, speed[j], law)
            for i in range(_STAGES):
                system[i, j] = (1.0 if i == j else 0.0) - from_torque[7 * i + 2, j] * slope
        for i in range(_STAGES):
            residual[i] = y[2] + linear[7 * i + 2] - speed[i]
            for j in range(_STAGES):
                residual[i] += from_torque[7 * i + 2, j] * torque[j]
        if not (np.isfinite(system).all() and np.isfinite(residual).all()):
            return False
        change = np.linalg.solve(system, residual)
        speed += change
        size = np.abs(change).max() / (1e-3 * law[3] + np.abs(speed).max())
        if not size < 1e3:
            return False
        if size < 1e-14 or (size < 1e-9 and size >= last):
            break
        if turn == 24:
            return False
        last = size
    for j in range(_STAGES):
        torque[j] = _torque(zone, speed[j], law)[0]
    increments[:] = linear + from_torque @ torque
    return True


@compiled
def _two_halves(
    y: FloatArray,
    zone: int,
    law: FloatArray,
    half: tuple[FloatArray, FloatArray, FloatArray],
    first: FloatArray,
    second: FloatArray,
) -> bool:
    """Two steps, one after another, their increments in `first` and `second`."""
    good: bool = _stages(y, zone, law, *half, first) and _stages(y + first[-7:], zone, law, *half, second)
    return good


@compiled
def _first_beyond(
    speed: float, zone: int, omega_s: float, first: FloatArray, second: FloatArray
) -> tuple[float, float]:
    """The share of a step in two halves where its bit speed, `speed` at the start, is first seen in another zone.

    2 where it is not; and the speed (rad/s) of the kink in between.
    """
    for half in range(2):
        stages = first if half == 0 else second
        for k in range(_LOOKS):
            seen = speed
            for j in range(_STAGES):
                seen += _AT_LOOKS[k, j + 1] * stages[7 * j + 2]
            if (zone == 0 and abs(seen) >= omega_s) or (zone != 0 and zone * seen < omega_s):
                return 0.5 * (half + (k + 1.0) / _LOOKS), zone * omega_s if zone != 0 else np.sign(seen) * omega_s
        speed += first[-5]
    return 2.0, 0.0


@compiled
def _end_on_kink(
    y: FloatArray,
    zone: int,
    law: FloatArray,
    A: FloatArray,
    constant: FloatArray,
    edge: float,
    step: float,
    share: float,
    first: FloatArray,
    second: FloatArray,
) -> float:
    """The length (s) of the step that ends at the bit speed `edge` (rad/s); 0 where none is found.

    `step` (s) has been seen beyond it first at a `share` of it. By secants, and every third time by halves.
    """
    low, high = max(0.0, share - 0.5 / _LOOKS) * step, share * step
    omega_s, length = law[3], high
    leaving = 1.0 if (zone == 0 and edge > 0.0) or zone == -1 else -1.0
    at_low, at_high = np.nan, np.nan
    for turn in range(80):
        if not _two_halves(y, zone, law, _prepare(A, constant, law[4], 0.5 * length), first, second):
            return 0.0
        beyond = leaving * (y[2] + first[-5] + second[-5] - edge)
        if beyond >= 0.0:
            high, at_high = length, beyond
        else:
            low, at_low = length, beyond
        rounding = 1e-15 * (abs(y[2]) + abs(first[-5]))
        if abs(beyond) <= max(rounding, 1e-13 * max(omega_s, 1e-3)) or high - low < 1e-14 * step:
            return length
        if turn % 3 == 2 or np.isnan(at_low) or np.isnan(at_high):
            length = 0.5 * (low + high)
        else:
            length = low + (high - low) * at_low / (at_low - at_high)
    return 0.0


@compiled
def _solve(
    states: FloatArray, A: FloatArray, constant: FloatArray, law: FloatArray, period: float, tolerance: float
) -> bool:
    """All `states` after the first; False where no step is short enough."""
    omega_s, n = law[3], 7 * _STAGES
    from_start, from_constant = np.empty((_LEVELS, n, 7)), np.empty((_LEVELS, n))
    from_torque, known = np.empty((_LEVELS, n, _STAGES)), np.zeros(_LEVELS, dtype=np.bool_)
    whole, first, second = np.empty(n), np.empty(n), np.empty(n)
    y, scale = states[0].copy(), np.maximum(1.0, np.abs(states[0]))
    parts = int(np.ceil(period / _LONGEST))
    longest, level = period / parts, _FIRST_LEVEL
    zone = 1 if y[2] >= omega_s else (-1 if y[2] <= -omega_s else 0)
    for part in range(parts * (states.shape[0] - 1)):
        left = longest
        while left > 1e-15 * longest:
            step = longest / 2.0**level
            if step > left * (1.0 + 1e-12):  # what is left of a step that a kink has cut
                step = left
                entire, half = _prepare(A, constant, law[4], step), _prepare(A, constant, law[4], 0.5 * step)
            else:
                for k in (level, level + 1):
                    if not known[k]:
                        tables = _prepare(A, constant, law[4], longest / 2.0**k)
                        from_start[k], from_constant[k], from_torque[k] = tables
                        known[k] = True
                entire = from_start[level], from_constant[level], from_torque[level]
                half = from_start[level + 1], from_constant[level + 1], from_torque[level + 1]
            good = _stages(y, zone, law, *entire, whole) and _two_halves(y, zone, law, half, first, second)
            change = first[-7:] + second[-7:]
            error = np.abs((whole[-7:] - change) / scale).max() if good else np.inf
            if not error < tolerance:
                level += 1
                if level + 1 >= _LEVELS:
                    return False
                continue
            share, edge = _first_beyond(y[2], zone, omega_s, first, second)
            if share <= 1.0:
                length = _end_on_kink(y, zone, law, A, constant, edge, step, share, first, second)
                if length == 0.0:
                    return False
                y += first[-7:] + second[-7:]
                y[2] = edge
                left -= length
                zone = 0 if zone != 0 else (1 if edge > 0.0 else -1)
                level = min(level + _AFTER_KINK, _LEVELS - 2)
            else:
                y += change
                left -= step
                if error < 1e-4 * tolerance and level > 0:
                    level -= 1
            scale = np.maximum(scale, np.abs(y))
            if not np.isfinite(y).all():
                return False
        if (part + 1) % parts == 0:
            states[(part + 1) // parts] = y
    return True
