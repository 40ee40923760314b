"""The fast settling of a bit that sticks, split off the state so that it does not rule the length of the steps.

In the stick zone T_r1 = sigma x_3 with sigma = N_1 r_1 mu_s / omega_s, and the model is linear,
y' = (M + sigma b e_3^T) y + constant. One of its modes is x_3 settling, at a rate near sigma / J_1, within
microseconds. With its right and left eigenvectors v and u the state at the start of a stick is split as
y = (y - a v) + a v, with a = u (y - y*) and y* the equilibrium in the zone: the first part has no fast settling in it
and takes steps of any length; the second is a v exp(z t).

Where this mode is much faster than all others, v and u come out of a few rounds of power iteration. Where another is as
fast, such as that of an armature without inductance, they come out of the equation of this very mode: with entry 3
of v put to 1, the six others solve (M_66 - z) v_6 = -M_63, and then z = M_33 + sigma b_3 + M_36 v_6.
"""

from __future__ import annotations

from drillrig_env.arrays import FloatArray, Record
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.stepper.ladder import STATE, length_of

_POWER_LIMIT, _POWER_TOLERANCE = 10, 1e-8
"""Most rounds of power iteration, and the last change of an eigenvector whose entry 3 is 1, in its units."""

_MODE_LIMIT, _MODE_TOLERANCE = 30, 1e-13
"""Most rounds for the one mode, and the last change of its rate, as a share of it."""

_FAR_FROM_EXPECTED = 0.5
"""A mode whose rate differs by more than this share from what x_3 alone would have is another one."""


_STEADY = 0.01
"""How wrong x_3 may be, as a share of `landed`, by a tilted disc that turns while it settles."""

_FAST = 0.05
"""A polynomial follows a mode that falls by less than this share within a step."""


@compiled
def split(y: FloatArray, contact: Record, ladder: Record, rung: int, work: Record) -> tuple[float, float]:
    """Take the fast settling out of `y`: its amplitude a (rad/s) and rate z (a step); its vector is `work.fast`.

    Where there is no such mode, a polynomial follows it, or a tilted disc turns too far while it settles, z is 0 and
    `y` remains as it was. The mode is that of the rig and its contact and is found once for both, where
    `work.fast_gain` is 0; on a tilted disc at every angle.
    """
    right, left = work.fast, work.fast_left
    gain, length = contact.static / contact.omega_s * ladder.rate_from_torque[2], length_of(rung)
    if contact.tilt > 0.0:
        gain *= 1.0 + work.cosine
    if work.fast_gain == 0.0 or contact.tilt > 0.0:
        work.fast_gain, work.fast_rate = gain, _mode(gain, ladder, work)
    rate = work.fast_rate * length
    if not rate < -_FAST:
        return 0.0, 0.0
    # u M_s = z u and M_s y* = -b sigma omega_ref give u y* = -u b sigma omega_ref / z; and u v is to be 1.
    amplitude, norm = gain * length * contact.speed_reference / rate, 0.0
    for i in range(7):
        amplitude += left[i] * y[i]
        norm += left[i] * right[i]
    amplitude /= norm
    if contact.tilt > 0.0:
        turning = contact.tilt * contact.turns * contact.omega_s * work.length
        if abs(amplitude) * turning > _STEADY * ladder.landed * -rate:
            return 0.0, 0.0
    for i in range(STATE):
        y[i] -= amplitude * right[i]
    return amplitude, rate


@inlined
def _mode(gain: float, ladder: Record, work: Record) -> float:
    """The rate (a step) of x_3 settling, its vectors in `work.fast` and `work.fast_left`; 0 where there is none."""
    expected = gain + ladder.rate_from_state[2, 2]
    rate = _power_iteration(gain, ladder, work)
    if not (rate < 0.0 and abs(rate - expected) <= -_FAR_FROM_EXPECTED * expected):
        rate = _settling_mode(gain, ladder, work)
    return rate


@inlined
def _power_iteration(gain: float, ladder: Record, work: Record) -> float:
    """The rate of the fastest mode, its vectors in `work.fast` and `work.fast_left`; 0 where none is much faster."""
    right, left, new, unit = work.fast, work.fast_left, work.state, ladder.unit
    for i in range(STATE):
        right[i] = left[i] = 1.0 if i == 2 else 0.0
    rate = float(gain)
    for _ in range(_POWER_LIMIT):
        for i in range(STATE):
            new[i] = 0.0
        for k in range(7):
            for i in range(STATE):
                new[i] += ladder.rate_from_state[k, i] * right[k]
        rate = float(new[2]) + gain
        new[2] = rate
        found, scale = True, 1.0 / new[2]
        for i in range(7):
            value = scale * new[i]
            found &= abs(value - right[i]) * unit[2] < _POWER_TOLERANCE * unit[i]
            right[i] = value
        for k in range(7):
            new[k] = 0.0
            for i in range(7):
                new[k] += ladder.rate_from_state[k, i] * left[i]
        new[2] += gain
        scale = 1.0 / new[2]
        for i in range(7):
            value = scale * new[i]
            found &= abs(value - left[i]) * unit[i] < _POWER_TOLERANCE * unit[2]
            left[i] = value
        if found:
            return rate
    return 0.0


@compiled
def _settling_mode(gain: float, ladder: Record, work: Record) -> float:
    """The rate of the mode nearest to that of x_3 alone, its vectors as above; 0 where none is found."""
    right, left, M = work.fast, work.fast_left, ladder.rate_from_state
    own = gain + M[2, 2]
    rate = own
    for _ in range(_MODE_LIMIT):
        if not _solve_others(rate, True, ladder, work, right):
            return 0.0
        new = own
        for k in range(7):
            if k != 2:
                new += M[k, 2] * right[k]
        change, rate = abs(new - rate), new
        if change <= _MODE_TOLERANCE * abs(rate):
            found = _solve_others(rate, True, ladder, work, right) and _solve_others(rate, False, ladder, work, left)
            return rate if found and abs(rate - own) <= -_FAR_FROM_EXPECTED * own else 0.0
    return 0.0


@compiled
def _solve_others(rate: float, is_right: bool, ladder: Record, work: Record, vector: FloatArray) -> bool:
    """The six other entries of an eigenvector whose entry 3 is 1, by elimination with pivots; False where singular."""
    M, A, unit = ladder.rate_from_state, work.reduced, ladder.unit
    for i in range(6):
        to = i if i < 2 else i + 1
        for k in range(6):
            source = k if k < 2 else k + 1
            entry = M[source, to] if is_right else M[to, source]
            # In units, so that the choice of a pivot does not hang on them.
            A[i, k] = entry * (unit[source] / unit[to] if is_right else unit[to] / unit[source])
            if i == k:
                A[i, k] -= rate
        A[i, 6] = -(M[2, to] * unit[2] / unit[to] if is_right else M[to, 2] * unit[to] / unit[2])
    for column in range(6):
        pivot = column
        for i in range(column + 1, 6):
            if abs(A[i, column]) > abs(A[pivot, column]):
                pivot = i
        if A[pivot, column] == 0.0:
            return False
        for k in range(7):
            A[column, k], A[pivot, k] = A[pivot, k], A[column, k]
        for i in range(column + 1, 6):
            share = A[i, column] / A[column, column]
            for k in range(column, 7):
                A[i, k] -= share * A[column, k]
    for column in range(5, -1, -1):
        for k in range(column + 1, 6):
            A[column, 6] -= A[column, k] * A[k, 6]
        A[column, 6] /= A[column, column]
    vector[2], vector[STATE - 1] = 1.0, 0.0
    for i in range(6):
        to = i if i < 2 else i + 1
        vector[to] = A[i, 6] * (unit[to] / unit[2] if is_right else unit[2] / unit[to])
    return True
