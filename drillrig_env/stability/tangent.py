"""A trajectory and the derivative of the flow along it, from one passage of a section to the next, in compiled code.

The section is x_3 = omega_ref with the bit speeding up, for the first time after a stick. Slip is solved by the
stepper's collocation, and what a change of the start does to a step is the derivative of that solution; stick is
linear, and one matrix exponential does both.
Steps end where the law has its kink, and at the section, by ever shorter ones. At the kink (4-9) steps by a share
v_b omega_s of the friction's fall: by how much earlier or later a trajectory gets there, it has the one rate or the
other (the saltation matrix).
"""

from __future__ import annotations

from math import copysign, nan

import numpy as np

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.friction.law import torque_in_zone, zone_of
from drillrig_env.jit.compiled import compiled
from drillrig_env.stepper.caution import caution_for
from drillrig_env.stepper.collocation import solve_nodes, take_step
from drillrig_env.stepper.exponentials import NODES
from drillrig_env.stepper.ladder import STATE, table_of

SHORTEST = 30
"""The rung of the shortest steps, with which kinks and the section are met: 5e-11 s, for the chapter's rig."""

COLUMNS = 8
"""Columns of the derivative: by each of the 7 states, and by the speed reference."""

_LONGEST_IN_STICK = 2  # rungs below the longest: what leaves the stick zone within a step and comes back is not seen
_ROUNDING = 2.0**-48  # of the speed reference, from which the bit speed is counted
_LONGEST_SLIP, _LONGEST_STICK = 400, 40_000  # periods; several swings of the string, and a stick at low speed
_MOST_STEPS = 1 << 20


@compiled
def follow(
    works: Records,
    derivative: FloatArray,
    ladder: Record,
    stick: FloatArray,
    stuck_state: FloatArray,
    with_derivative: bool,
) -> tuple[float, float]:
    """Follow a rig to its next passage of the section, in place; the periods that it took, and those in the stick zone.

    works        one WORKSPACE record, with the states less the frictionless equilibrium as `y`, and the `contact`
    derivative   shape (7, COLUMNS): of `y` by the states and the speed reference at the start; identity to begin with
    ladder       the LADDER record of the rig
    stick        shape (SHORTEST + 1, 7, 7): the flow in the stick zone over the step of each rung
    stuck_state  shape (7,): what of `y` would hold still in the stick zone, for a speed reference of 1 rad/s

    NaN where the bit does not pass the section, or sticks no more.
    """
    work = works[0]
    y, contact = work.y, work.contact
    speed, rounding = contact.speed_reference, _ROUNDING * contact.speed_reference
    edge, knee = contact.omega_s - rounding, contact.knee - rounding
    new, before, nodes = np.zeros((7, COLUMNS)), np.zeros(STATE), np.zeros((NODES, NODES + COLUMNS))
    work.caution = caution_for(contact, ladder)
    first = ladder.first
    zone, rung, approaching, passes = zone_of(y[2] + speed, edge, knee), first, False, False
    has_stuck = False
    elapsed, in_stick = 0, 0
    for _ in range(_MOST_STEPS):
        for i in range(STATE):
            before[i] = y[i]
        solved, leaves = True, False
        if zone == 0:
            rung = max(rung, first + _LONGEST_IN_STICK)
            _take_stick_step(y, before, speed, stick[rung], stuck_state)
            if approaching and abs(y[2] - before[2]) < _ROUNDING * speed:  # rounding holds it there, next to the edge
                y[2] = copysign(contact.omega_s, y[2] + speed) - speed
            leaves = abs(y[2] + speed) >= edge
        else:
            reach = solve_nodes(y, zone, contact, ladder, rung, work)
            solved, leaves = reach != 0.0 or rung == SHORTEST, reach != 1.0 and reach != 0.0
            if not leaves or rung == SHORTEST:
                take_step(y, table_of(ladder, rung), work)
                leaves = zone_of(y[2] + speed, edge, knee) != zone
                passes = has_stuck and before[2] < 0.0 <= y[2]
        if (leaves or passes or not solved) and rung < SHORTEST:
            for i in range(STATE):
                y[i] = before[i]
            rung, approaching, passes = rung + 1, leaves or passes, False
            continue
        if with_derivative:
            if zone == 0:
                _differentiate_stick(derivative, new, stick[rung], stuck_state)
            else:
                _differentiate_slip(derivative, new, nodes, zone, contact, table_of(ladder, rung), work)
        elapsed += 1 << (SHORTEST - rung)
        in_stick += 1 << (SHORTEST - rung) if zone == 0 else 0
        if passes:
            return elapsed / (1 << SHORTEST), in_stick / (1 << SHORTEST)
        has_stuck |= zone == 0
        if elapsed - in_stick > _LONGEST_SLIP << SHORTEST or in_stick > _LONGEST_STICK << SHORTEST:
            break
        if rung == SHORTEST:
            approaching = False
            if leaves:
                left, zone = zone, zone_of(y[2] + speed, edge, knee)
                share = _rate_of_bit(y, zone, contact, ladder) / _rate_of_bit(y, left, contact, ladder) - 1.0
                for column in range(COLUMNS if with_derivative else 0):
                    derivative[2, column] += share * (derivative[2, column] + (1.0 if column == 7 else 0.0))
        if not approaching:
            rung = max(rung - 1, first)
    return nan, nan


@compiled
def _rate_of_bit(y: FloatArray, zone: int, contact: Record, ladder: Record) -> float:
    """The rate of x_3 under one piece of the law."""
    torque, _ = torque_in_zone(zone, y[2] + contact.speed_reference, contact)
    rate = torque * ladder.rate_from_torque[2]
    for k in range(7):
        rate += y[k] * ladder.rate_from_state[k, 2]
    return float(rate)


@compiled
def _take_stick_step(
    y: FloatArray, before: FloatArray, speed: float, flow: FloatArray, stuck_state: FloatArray
) -> None:
    for i in range(7):
        y[i] = speed * stuck_state[i]
        for k in range(7):
            y[i] += flow[i, k] * (before[k] - speed * stuck_state[k])


@compiled
def _differentiate_stick(derivative: FloatArray, new: FloatArray, flow: FloatArray, stuck_state: FloatArray) -> None:
    for i in range(7):
        for column in range(COLUMNS):
            new[i, column] = 0.0
            for k in range(7):
                new[i, column] += flow[i, k] * derivative[k, column]
        new[i, 7] += stuck_state[i]
        for k in range(7):
            new[i, 7] -= flow[i, k] * stuck_state[k]
    derivative[:] = new


@compiled
def _differentiate_slip(
    derivative: FloatArray,
    new: FloatArray,
    nodes: FloatArray,
    zone: int,
    contact: Record,
    table: Record,
    work: Record,
) -> None:
    """The derivative of a solved step: at the nodes (1 - A diag(slope)) x_3' = y' of the start, as in its solution."""
    slope, width = work.slope, NODES + COLUMNS
    for j in range(NODES):
        _, slope[j] = torque_in_zone(zone, work.speed[j], contact)
    for j in range(NODES):
        for k in range(NODES):
            nodes[j, k] = (1.0 if j == k else 0.0) - table.node_from_torque[j, k] * slope[k]
        for column in range(COLUMNS):
            nodes[j, NODES + column] = 1.0 if column == 7 else 0.0
            for k in range(7):
                nodes[j, NODES + column] += table.node_from_state[k, j] * derivative[k, column]
    for pivot in range(NODES):  # the identity plus a Radau matrix: no exchange of rows is needed
        for column in range(pivot + 1, width):
            nodes[pivot, column] /= nodes[pivot, pivot]
        for j in range(NODES):
            if j != pivot:
                for column in range(pivot + 1, width):
                    nodes[j, column] -= nodes[j, pivot] * nodes[pivot, column]
    for i in range(7):
        for column in range(COLUMNS):
            new[i, column] = 0.0
            for k in range(7):
                new[i, column] += table.state_from_state[k, i] * derivative[k, column]
            for j in range(NODES):
                new[i, column] += table.state_from_torque[j, i] * (slope[j] * nodes[j, NODES + column])
    derivative[:] = new
