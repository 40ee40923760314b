"""The fast stepper as a map: the flow over any time, and the return to a section of the state space.

The section is x_3 = omega_ref with the bit speeding up, which every periodic orbit of the rig crosses
once a period. Times are met to the last bit by whole periods, whole units of the finest step, and one
last fraction of a microsecond at the present rate.
"""

from __future__ import annotations

import numpy as np

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.friction import Friction
from drillrig_env.friction.law import torque_in_zone, zone_of
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.model import friction_input, jacobian
from drillrig_env.rig import Rig
from drillrig_env.stepper.propagator import advance, workspace
from drillrig_env.stepper.tables import STATE, UNITS, from_equilibrium, step_tables, to_states

_PERIOD = 0.05  # s
_LONGEST_RETURN = 4000  # periods


def flow(rig: Rig, friction: Friction, speed_reference: float, states: FloatArray, time: float) -> FloatArray:
    """States of shape (n, 7) after any `time` (s) at constant speed reference (rad/s)."""
    contacts = friction.single().contacts(rig, speed_reference)
    matrix, tables = _rates_matrix(rig), step_tables(rig, _PERIOD)
    result = np.array(states, dtype=float)
    _flow(result, time, contacts, matrix, tables.rungs, tables.sampling, tables.shift, workspace())
    return result


def next_crossings(
    rig: Rig, friction: Friction, speed_reference: float, states: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Run states of shape (n, 7) to their next crossing of the section.

    Returns the states there and the times taken (s; NaN where 200 s brought none).
    """
    contacts = friction.single().contacts(rig, speed_reference)
    matrix, tables = _rates_matrix(rig), step_tables(rig, _PERIOD)
    result, times = np.array(states, dtype=float), np.empty(len(states))
    _cross(result, times, contacts, matrix, tables.rungs, tables.sampling, tables.shift, workspace())
    return result, times


def _rates_matrix(rig: Rig) -> FloatArray:
    """The rates as a matrix (7, 8) of the states relative to the equilibrium, and the friction torque."""
    return np.column_stack([jacobian(rig), friction_input(rig)])


@compiled
def _flow(
    states: FloatArray,
    time: float,
    contacts: Records,
    matrix: FloatArray,
    rungs: Records,
    sampling: Records,
    shift: Records,
    works: Records,
) -> None:
    work = works[0]
    y, contact = work.y, contacts[0]
    periods = int(time / _PERIOD)
    units = int((time - periods * _PERIOD) / _PERIOD * UNITS)
    rest = time - _PERIOD * (periods + units / UNITS)
    for n in range(states.shape[0]):
        from_equilibrium(states[n], contact, shift, y)
        for _ in range(periods):
            advance(y, contact, rungs, sampling, work, False, UNITS)
        advance(y, contact, rungs, sampling, work, False, units)
        _drift(y, contact, matrix, rest)
        to_states(y, contact, shift, states[n])


@compiled
def _cross(
    states: FloatArray,
    times: FloatArray,
    contacts: Records,
    matrix: FloatArray,
    rungs: Records,
    sampling: Records,
    shift: Records,
    works: Records,
) -> None:
    work = works[0]
    y, before, contact = work.y, np.zeros(STATE), contacts[0]
    for n in range(states.shape[0]):
        from_equilibrium(states[n], contact, shift, y)
        times[n] = np.nan
        for period in range(_LONGEST_RETURN):
            _copy(y, before)
            advance(y, contact, rungs, sampling, work, False, UNITS)
            if before[2] < 0.0 <= y[2]:
                units = _locate(before, y, contact, rungs, sampling, work)
                rest = -y[2] / _rate(y, 2, contact, matrix)
                _drift(y, contact, matrix, rest)
                times[n] = _PERIOD * (period + units / UNITS) + rest
                break
        to_states(y, contact, shift, states[n])


@compiled
def _locate(before: FloatArray, y: FloatArray, contact: Record, rungs: Records, sampling: Records, work: Record) -> int:
    """Bisect for the last unit before the crossing, leaving `y` there; the units from `before`."""
    low, high = 0, UNITS
    while high - low > 1:
        middle = (low + high) // 2
        _copy(before, y)
        advance(y, contact, rungs, sampling, work, False, middle)
        if y[2] < 0.0:
            low = middle
        else:
            high = middle
    _copy(before, y)
    advance(y, contact, rungs, sampling, work, False, low)
    return low


@inlined
def _copy(source: FloatArray, target: FloatArray) -> None:
    for i in range(STATE):
        target[i] = source[i]


@compiled
def _rate(y: FloatArray, i: int, contact: Record, matrix: FloatArray) -> float:
    """Present rate of state i."""
    x_3 = y[2] + contact.speed_reference
    torque, _ = torque_in_zone(zone_of(x_3, contact.omega_s), x_3, contact)
    rate = float(matrix[i, 7] * torque)
    for k in range(7):
        rate += matrix[i, k] * y[k]
    return rate


@compiled
def _drift(y: FloatArray, contact: Record, matrix: FloatArray, time: float) -> None:
    """Move `y` on by less than one unit, at its present rates."""
    rates = np.zeros(7)
    for i in range(7):
        rates[i] = _rate(y, i, contact, matrix)
    for i in range(7):
        y[i] += time * rates[i]
