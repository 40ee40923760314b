"""The fast exact stepper: one rig, one period of held speed reference, in compiled code.

A step solves for the bit speed at the four Radau nodes by Newton's method and then applies the
constant tables of `drillrig_env.ladder`. Only the kinks of (4-9) at |x_3| = omega_s need care. A step
is taken with the piece of the law that holds where it begins, and kept if no node leaves that piece;
otherwise it is halved, down a ladder of tables whose last rung is below a microsecond. On the way
back up steps double, which also resolves the fast settling at the start of a stick.
"""

from __future__ import annotations

import numpy as np

from drillrig_env.compiled import Record, Records, compiled, inlined
from drillrig_env.friction import FloatArray, torque_in_zone, zone_of
from drillrig_env.ladder import NODES, RUNGS, SAMPLED_RUNGS, SAMPLES, START_FROM_NODES, STATE, UNITS

_SAMPLE_UNITS = UNITS // SAMPLES
_NEWTON_LIMIT = 8
_NEWTON_TOLERANCE = 1e-5
"""Newton's last step (rad/s); convergence is quadratic, so the error left is far below its square."""

_CLEARLY_BEYOND = 0.02
"""An iterate this far (rad/s) beyond the kink means that the step crosses it."""

_SLIP_DEFECT, _STICK_DEFECT = 1e-5, 1e-6
"""Largest distance (N m) of T_r1 at the start of a step from the cubic through its node values, in
slip and in stick. The start is no node, so the distance tells how well a cubic follows T_r1."""

WORKSPACE = np.dtype(
    [
        ("linear", "f8", NODES),
        ("speed", "f8", NODES),
        ("torque", "f8", NODES),
        ("slope", "f8", NODES),
        ("system", "f8", (NODES, NODES + 1)),
        ("state", "f8", STATE),
        ("speed_samples", "f8", SAMPLES),
        ("torque_samples", "f8", SAMPLES),
    ],
    align=True,
)
"""Scratch numbers of one rig's step; `advance` leaves its samples in the last two fields."""


@compiled
def advance(
    y: FloatArray,
    speed_reference: float,
    static: float,
    kinetic: float,
    v_b: float,
    omega_s: float,
    rungs: Records,
    sampling: Records,
    work: Record,
    sampled: bool,
    stop: int,
) -> None:
    """Advance one rig over one period of held input, or its first `stop` of UNITS units, in place.

    y                shape (8,): the 7 states less the frictionless equilibrium, and a pad
    speed_reference  omega_ref, rad/s
    static, kinetic  N_1 r_1 mu_s and N_1 r_1 mu_k, N m;  v_b in s/rad, omega_s in rad/s
    rungs, sampling  the tables of a `Ladder`
    work             a WORKSPACE record; where `sampled` is true, its SAMPLES samples of bit speed
                     (rad/s) and string torque (N m) are taken at equal distances, the last at the end
    """
    position, rung = 0, 0
    while position < stop:
        size = UNITS >> rung
        last = rung == RUNGS - 1
        if (
            position % size != 0
            or position + size > stop
            or not _solve_nodes(y, speed_reference, static, kinetic, v_b, omega_s, rungs[rung], work, last)
        ):
            rung += 1
            continue
        if sampled and rung < SAMPLED_RUNGS:
            _sample_step(y, speed_reference, sampling[rung], work, position // _SAMPLE_UNITS, SAMPLES >> rung)
        _take_step(y, rungs[rung], work)
        position += size
        if sampled and rung >= SAMPLED_RUNGS and position % _SAMPLE_UNITS == 0:
            _sample_state(y, speed_reference, sampling[0], work, position // _SAMPLE_UNITS - 1)
        if rung > 0:
            rung -= 1


@inlined
def _solve_nodes(
    y: FloatArray,
    speed_reference: float,
    static: float,
    kinetic: float,
    v_b: float,
    omega_s: float,
    table: Record,
    work: Record,
    last: bool,
) -> bool:
    """Solve for bit speed and friction torque at the nodes of a step; False if the step must be halved.

    The law is the smooth continuation of the piece that holds at the start. Newton's method begins
    from the law's tangent there, which in the stick zone, where the law is linear, is the solution.
    """
    start = y[2] + speed_reference
    zone = zone_of(start, omega_s)
    torque, slope = torque_in_zone(zone, start, static, kinetic, v_b, omega_s)
    for j in range(NODES):
        linear = speed_reference
        for k in range(7):
            linear += y[k] * table.node_from_state[k, j]
        work.linear[j] = linear
        work.speed[j], work.torque[j], work.slope[j] = start, torque, slope
    for _ in range(_NEWTON_LIMIT):
        change = _newton_step(table, work)
        if zone == 0 or change < _NEWTON_TOLERANCE:
            return last or _is_accurate(start, torque, zone, omega_s, work)
        for j in range(NODES):
            if not last and zone * work.speed[j] < omega_s - _CLEARLY_BEYOND:
                return False
            work.torque[j], work.slope[j] = torque_in_zone(zone, work.speed[j], static, kinetic, v_b, omega_s)
    return last


@inlined
def _newton_step(table: Record, work: Record) -> float:
    """One Newton step for speed = linear + node_from_torque @ torque(speed); returns its largest entry.

    Gaussian elimination needs no pivots here: the matrix is the identity plus a Radau matrix.
    """
    system = work.system
    for i in range(NODES):
        residual = work.linear[i] - work.speed[i]
        for j in range(NODES):
            residual += table.node_from_torque[i, j] * work.torque[j]
            system[i, j] = -table.node_from_torque[i, j] * work.slope[j]
        system[i, i] += 1.0
        system[i, NODES] = residual
    for i in range(NODES):
        inverse = 1.0 / system[i, i]
        for k in range(i + 1, NODES):
            factor = system[k, i] * inverse
            for j in range(i + 1, NODES + 1):
                system[k, j] -= factor * system[i, j]
    largest = 0.0
    for i in range(NODES - 1, -1, -1):
        step = system[i, NODES]
        for j in range(i + 1, NODES):
            step -= system[i, j] * system[j, NODES]
        step /= system[i, i]
        system[i, NODES] = step
        work.speed[i] += step
        work.torque[i] += work.slope[i] * step
        largest = max(largest, abs(step))
    return largest


@inlined
def _is_accurate(start: float, torque: float, zone: int, omega_s: float, work: Record) -> bool:
    """Whether a solved step keeps to its piece of the law, and a cubic follows T_r1 over it."""
    lowest = highest = start
    defect = torque
    for j in range(NODES):
        lowest, highest = min(lowest, work.speed[j]), max(highest, work.speed[j])
        defect -= START_FROM_NODES[j] * work.torque[j]
    if zone == 0:
        return abs(defect) <= _STICK_DEFECT and lowest > -omega_s and highest < omega_s
    nearest = lowest if zone == 1 else -highest
    if zone * (work.speed[0] - start) < 0.0:
        # Slowing down: the speed may dip between two nodes by a fraction of its range.
        nearest -= (highest - lowest) / 8.0
    return abs(defect) <= _SLIP_DEFECT and nearest >= omega_s


@inlined
def _take_step(y: FloatArray, table: Record, work: Record) -> None:
    new = work.state
    for i in range(STATE):
        total = 0.0
        for k in range(7):
            total += y[k] * table.state_from_state[k, i]
        for j in range(NODES):
            total += work.torque[j] * table.state_from_torque[j, i]
        new[i] = total
    for i in range(STATE):
        y[i] = new[i]


@inlined
def _sample_step(y: FloatArray, speed_reference: float, table: Record, work: Record, first: int, count: int) -> None:
    """Samples inside a solved step that is about to be taken, as entries `first` and on."""
    for i in range(count):
        speed, torque = speed_reference, 0.0
        for k in range(7):
            speed += y[k] * table.speed_from_state[k, i]
            torque += y[k] * table.torque_from_state[k, i]
        for j in range(NODES):
            speed += work.torque[j] * table.speed_from_torque[j, i]
            torque += work.torque[j] * table.torque_from_torque[j, i]
        work.speed_samples[first + i], work.torque_samples[first + i] = speed, torque


@inlined
def _sample_state(y: FloatArray, speed_reference: float, table: Record, work: Record, index: int) -> None:
    """The sample of a state that lies on the grid, as entry `index`."""
    torque = 0.0
    for k in range(7):
        torque += y[k] * table.torque_row[k]
    work.speed_samples[index], work.torque_samples[index] = y[2] + speed_reference, torque
