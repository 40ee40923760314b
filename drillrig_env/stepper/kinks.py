"""Steps that meet the kinks of (4-9): find where, land there, and go on with the other piece of the law.

A solved step gives T_r1 as a cubic of time, with which the state at any time within the step is a
Taylor series of y' = M y + b T_r1, exact to rounding. So a step ends just where |x_3| = omega_s.

In the stick zone T_r1 = sigma x_3 with sigma = N_1 r_1 mu_s / omega_s, and the model is linear,
y' = (M + sigma b e_3^T) y + constant. One of its modes is much faster than all others: x_3 settling, at
a rate near sigma / J_1, within microseconds. Its right and left eigenvectors v and u come out of a few
rounds of power iteration. At the start of a stick the state is split as y = (y - a v) + a v, with
a = u (y - y*) and y* the equilibrium in the zone: the first part has no fast settling in it and takes
steps of any length; the second is a v exp(z t).
"""

from __future__ import annotations

from math import exp

from drillrig_env.arrays import FloatArray, Record
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.jit.simd import row, store
from drillrig_env.stepper.collocation import solve_nodes
from drillrig_env.stepper.tables import NODES, POWERS_FROM_NODES, STATE

_PIECES = 4
"""Most pieces of the law within one step; with more, shorter steps are taken."""

_SETTLED = 1e-10
"""What may be left of the fast settling (rad/s) where the bit leaves the stick zone."""

_TAYLOR_LIMIT, _TAYLOR_TOLERANCE = 40, 1e-13
"""Most terms of a Taylor series, and the size of the last one in any state."""

_POWER_LIMIT, _POWER_TOLERANCE = 10, 1e-8
"""Most rounds of power iteration, and the last change of an eigenvector whose entry 3 is 1."""


@compiled
def step_through_kinks(y: FloatArray, zone: int, contact: Record, table: Record, work: Record, reach: float) -> bool:
    """Take a step that was solved up to `reach`, across the kinks within it; False, and `y` as it was, if it cannot.

    The arguments are those of `solve_nodes`, which has left its solution in `work`.
    """
    for i in range(STATE):
        work.before[i] = y[i]
    left = 1.0
    for piece in range(_PIECES):
        amplitude, rate = 0.0, 0.0
        rough_stick = zone == 0 and (piece > 0 or reach == 0.0)
        if rough_stick:
            amplitude, rate = _split(y, contact, table, work)
            if rate == 0.0:
                break
        if piece > 0 or rough_stick:
            reach = solve_nodes(y, zone, contact, table, work)
        settling = amplitude * exp(rate * min(reach, left))
        if reach == 0.0 or (reach < left and abs(settling) > _SETTLED):
            break
        if not _land(y, table, work, min(reach, left)):
            break
        if settling != 0.0:
            for i in range(STATE):
                y[i] += settling * work.fast[i]
        if reach >= left:
            return True
        left -= reach
        forwards = 1 if y[2] + contact.speed_reference > 0.0 else -1
        zone = 0 if zone != 0 else forwards
    for i in range(STATE):
        y[i] = work.before[i]
    return False


@compiled
def _land(y: FloatArray, table: Record, work: Record, share: float) -> bool:
    """Move `y` on within a solved step, by a `share` of it: the Taylor series of y' = M y + b T_r1.

    False where the series does not end: a motor of small inductance is too fast for a step of this length.
    """
    powers, term, M = work.powers, work.term, table.rate_from_state
    for i in range(NODES):
        powers[i] = 0.0
        for j in range(NODES):
            powers[i] += POWERS_FROM_NODES[i, j] * work.torque[j]
    for i in range(STATE):
        term[i] = y[i]
    scale = 1.0
    for order in range(1, _TAYLOR_LIMIT):
        torque = scale * powers[order - 1] if order <= NODES else 0.0
        scale *= share
        rate = torque * row(table.rate_from_torque, 0, STATE) + term[0] * row(M, 0, STATE)
        rate = rate + term[1] * row(M, 1, STATE) + term[2] * row(M, 2, STATE) + term[3] * row(M, 3, STATE)
        rate = rate + term[4] * row(M, 4, STATE) + term[5] * row(M, 5, STATE) + term[6] * row(M, 6, STATE)
        store(term, 0, share / order * rate)
        store(y, 0, row(y, 0, STATE) + row(term, 0, STATE))
        largest = 0.0
        for i in range(7):
            largest = max(largest, abs(term[i]))
        if largest < _TAYLOR_TOLERANCE and order >= NODES:
            return True
    return False


@compiled
def _split(y: FloatArray, contact: Record, table: Record, work: Record) -> tuple[float, float]:
    """Take the fast settling out of `y`: its amplitude a (rad/s) and rate z (a step); its vector is `work.fast`.

    Where no mode is much faster than the others, z is 0 and `y` remains as it was.
    """
    right, left, new = work.fast, work.fast_left, work.state
    for i in range(STATE):
        right[i] = left[i] = 1.0 if i == 2 else 0.0
    gain = contact.static / contact.omega_s * table.rate_from_torque[2]
    change, rate = 1.0, 0.0
    for _ in range(_POWER_LIMIT):
        for i in range(STATE):
            new[i] = 0.0
        for k in range(7):
            for i in range(STATE):
                new[i] += table.rate_from_state[k, i] * right[k]
        rate = new[2] + gain
        new[2] = rate
        change = _replace(right, new)
        for k in range(7):
            new[k] = 0.0
            for i in range(7):
                new[k] += table.rate_from_state[k, i] * left[i]
        new[2] += gain
        change = max(change, _replace(left, new))
        if change < _POWER_TOLERANCE:
            break
    if not (change < _POWER_TOLERANCE and rate < 0.0):
        return 0.0, 0.0
    # u M_s = z u and M_s y* = -b sigma omega_ref give u y* = -u b sigma omega_ref / z; and u v is to be 1.
    amplitude, norm = gain * contact.speed_reference / rate, 0.0
    for i in range(7):
        amplitude += left[i] * y[i]
        norm += left[i] * right[i]
    amplitude /= norm
    for i in range(STATE):
        y[i] -= amplitude * right[i]
    return amplitude, rate


@inlined
def _replace(vector: FloatArray, new: FloatArray) -> float:
    """Replace an eigenvector by a new one, scaled so that entry 3 is 1; returns the largest change."""
    change, scale = 0.0, 1.0 / new[2]
    for i in range(7):
        value = scale * new[i]
        change = max(change, abs(value - vector[i]))
        vector[i] = value
    return change
