"""How far the solution of a step holds: up to the kink of the law that it crosses, and where a cubic follows T_r1."""

from __future__ import annotations

import numpy as np

from drillrig_env.arrays import FloatArray, Record
from drillrig_env.friction.contact import EXPONENTIAL
from drillrig_env.friction.law import edges_of, torque_in_zone
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.jit.simd import row, store
from drillrig_env.stepper.exponentials import BETWEEN, NODES, POWERS_FROM_NODES, RADAU_NODES
from drillrig_env.stepper.ladder import table_of
from drillrig_env.stepper.turning import SMALL_TURN, turn_between

_NEWTON_LIMIT = 8

_PER_FALL = 1.0 / 6.0
"""How errors weigh more where friction falls further than to 1/e^6 within a step: its polynomial tells them less."""

_ROUNDING = 64.0 * 2.0**-52

_AT_ONCE = 2.0**-60
"""The share of a step after which one that begins at a kink, and goes on beyond it, has met it."""

_CROSSING_TOLERANCE = 1e-9
"""Newton's last step in search of a crossing, as a share of the step."""

_BETWEEN_FROM_NODES = np.vander(BETWEEN, NODES, increasing=True) @ POWERS_FROM_NODES
"""The cubic through the node values, between the nodes."""

_POWERS_OF_RATES = POWERS_FROM_NODES / RADAU_NODES
"""Coefficients of the cubic through (value at a node - value at the start) / time of the node."""


@inlined
def reach_of(
    y: FloatArray, start: float, torque: float, zone: int, contact: Record, ladder: Record, rung: int, work: Record
) -> float:
    """The share of a solved step over which its solution holds, as `solve_nodes` returns it.

    The start of a step is no node, so how far T_r1 there lies from the cubic through its node values (the
    defect, N m) tells how well a cubic follows T_r1.
    """
    fine, lowest, highest = rung >= ladder.fine_from, work.speed[0], work.speed[0]
    nearer, farther = edges_of(zone, contact.omega_s, contact.knee)
    defect = torque - POWERS_FROM_NODES[0, 0] * work.torque[0]
    for j in range(1, NODES):
        lowest, highest = min(lowest, work.speed[j]), max(highest, work.speed[j])
        defect -= POWERS_FROM_NODES[0, j] * work.torque[j]
    weight = work.caution
    if zone != 0:
        weight *= max(1.0, _PER_FALL * contact.v_b * (max(highest, start) - min(lowest, start)))
    rough = not abs(defect) * weight <= ladder.largest_defect
    if rough and abs(defect) <= ladder.largest_defect / weight + _rounding(y, contact, ladder, work):
        rough = False
    if fine and rough:
        return 0.0
    watched = ladder.watched or (zone != 0 and (work.caution > 1.0 or contact.law != EXPONENTIAL))
    watched |= contact.tilt > 0.0 and work.turned > SMALL_TURN
    nearest, farthest = (lowest, highest) if zone > 0 else (-highest, -lowest)
    if (zone != 0 and nearest < nearer) or (zone == 0 and max(highest, -lowest) >= farther) or farthest >= farther:
        share = crossing(start, zone, contact, fine, work)
        held = not (watched and fine) or _follows(y, zone, contact, ladder, rung, work, weight, share)
        return share if held else 0.0
    # Where it turns the speed may dip, or peak, between two nodes by a fraction of its range.
    between = (max(highest, start) - min(lowest, start)) / 8.0
    if zone * (work.speed[0] - start) < 0.0:
        rough |= nearest - between < nearer
    elif zone != 0:
        rough |= farthest + between >= farther
    rough |= watched and not rough and not _follows(y, zone, contact, ladder, rung, work, weight, 1.0)
    return 0.0 if rough else 1.0


@compiled
def _follows(
    y: FloatArray, zone: int, contact: Record, ladder: Record, rung: int, work: Record, weight: float, share: float
) -> bool:
    """Whether the cubic follows T_r1 between the nodes too, up to a `share` of the step; `weight` counts its errors.

    The start alone may show no defect by chance, and none of a rise within a dip of the speed.
    """
    table, T, speeds = table_of(ladder, rung), work.torque, work.between
    A, b = table.between_from_state, table.between_from_torque
    linear = contact.speed_reference + y[0] * row(A, 0, NODES) + y[1] * row(A, 1, NODES) + y[2] * row(A, 2, NODES)
    linear = linear + y[3] * row(A, 3, NODES) + y[4] * row(A, 4, NODES) + y[5] * row(A, 5, NODES)
    linear = linear + y[6] * row(A, 6, NODES) + T[0] * row(b, 0, NODES) + T[1] * row(b, 1, NODES)
    store(speeds, 0, linear + T[2] * row(b, 2, NODES) + T[3] * row(b, 3, NODES))
    allowed = ladder.largest_defect / weight + _rounding(y, contact, ladder, work)
    nearer, farther = edges_of(zone, contact.omega_s, contact.knee)
    if contact.tilt > 0.0:
        turn_between(y[2] + contact.speed_reference, contact, work)
    for i in range(NODES):
        if BETWEEN[i] < share:
            torque, _ = torque_in_zone(zone, speeds[i], contact)
            if contact.tilt > 0.0:
                torque *= work.between_factor[i]
            cubic = 0.0
            for j in range(NODES):
                cubic += _BETWEEN_FROM_NODES[i, j] * T[j]
            size = speeds[i] if zone > 0 else -speeds[i]
            inside = nearer <= size < farther if zone != 0 else abs(size) < farther
            if not (inside and abs(torque - cubic) <= allowed):
                return False
    return True


@compiled
def rounding_of_speed(y: FloatArray, contact: Record, ladder: Record) -> float:
    """What rounding leaves uncertain of x_3 (rad/s), which is counted from the speed reference, beside the string."""
    largest = float(contact.speed_reference)
    for i in range(5):
        largest = max(largest, abs(y[i]) / ladder.unit[i] * ladder.unit[2])
    return _ROUNDING * largest


@compiled
def _rounding(y: FloatArray, contact: Record, ladder: Record, work: Record) -> float:
    """What rounding makes of T_r1 (N m), which is so steep, in the stick zone above all, that it shows that of x_3."""
    noise: float = _ROUNDING * abs(work.torque[0]) + abs(work.slope[0]) * rounding_of_speed(y, contact, ladder)
    return noise


@compiled
def crossing(start: float, zone: int, contact: Record, fine: bool, work: Record) -> float:
    """Where a step leaves its zone, as a share of the step; 0 where a node cannot tell.

    A first guess is linear between the first node beyond the kink and what comes before it. The
    `fine` answer is the root, by Newton's method, of the quartic through the start and the nodes.
    """
    nearer, farther = edges_of(zone, contact.omega_s, contact.knee)
    earlier, speed_then, share, edge, side = 0.0, start, 0.0, 0.0, (1.0 if zone >= 0 else -1.0)
    for j in range(NODES):
        speed = work.speed[j]
        size = side * speed
        if size < nearer or size >= farther or (zone == 0 and size <= nearer):
            edge = side * (nearer if size <= nearer else farther)
            if start == edge:
                return _AT_ONCE
            if (speed_then - edge) * (speed - edge) < 0.0:
                share = earlier + (RADAU_NODES[j] - earlier) * (edge - speed_then) / (speed - speed_then)
            break
        earlier, speed_then = RADAU_NODES[j], speed
    if not fine or share == 0.0:
        return share
    rates = work.powers  # coefficients of the mean rate since the start, a cubic of time
    for i in range(NODES):
        rates[i] = 0.0
        for j in range(NODES):
            rates[i] += _POWERS_OF_RATES[i, j] * (work.speed[j] - start)
    for _ in range(_NEWTON_LIMIT):
        mean = rates[0] + share * (rates[1] + share * (rates[2] + share * rates[3]))
        rate = rates[0] + share * (2.0 * rates[1] + share * (3.0 * rates[2] + share * 4.0 * rates[3]))
        step = (start + share * mean - edge) / rate
        share -= step
        if abs(step) < _CROSSING_TOLERANCE:
            return share if 0.0 < share < 1.0 else 0.0
    return 0.0
