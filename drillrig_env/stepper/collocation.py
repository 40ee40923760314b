"""One step of exponential collocation: bit speed and friction torque at the nodes, then the new state.

A step is solved with one piece of (4-9), continued smoothly beyond its zone: by Newton's method for
the bit speed at the four Radau nodes, which in the stick zone, where the law is linear, is one linear
solve. How far the solution holds is known afterwards (`drillrig_env.stepper.reach`).
"""

from __future__ import annotations

from drillrig_env.arrays import FloatArray, Record
from drillrig_env.friction.contact import EXPONENTIAL, LINEAR
from drillrig_env.friction.law import torque_in_zone
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.jit.simd import row, store
from drillrig_env.stepper.exponentials import NODES
from drillrig_env.stepper.ladder import STATE, table_of
from drillrig_env.stepper.reach import crossing, reach_of
from drillrig_env.stepper.turning import turn_nodes

_NEWTON_LIMIT = 8

_FARTHEST = 1.0
"""Newton's last step, in falls of the friction to 1/e, from which the slope still tells the error."""

_OF_DEFECT = 0.01
"""What may be wrong of the torque by the angle of a tilted disc, as a share of the largest defect."""


@compiled
def solve_nodes(y: FloatArray, zone: int, contact: Record, ladder: Record, rung: int, work: Record) -> float:
    """Solve a step with one piece of the law; the share of the step over which the solution holds.

    1 is the whole step; less means that it crosses the kink there, and 0 that no share is accurate.
    Above the first fine rung the place of a kink is a guess, good for choosing shorter steps. Newton's method
    begins from the law's tangent at the start. The other arguments are those of `advance`; `zone` is
    the piece of the law, `rung` the step's length.

    Newton's error is that of the linearised T_r1 at a node: half of T_r1'' step^2, with T_r1'' = -v_b T_r1'. Of other
    laws than the exponential one it is what the law differs by there.
    """
    speed_reference, omega_s = contact.speed_reference, contact.omega_s
    table, fine = table_of(ladder, rung), rung >= ladder.fine_from
    start = y[2] + speed_reference
    torque, slope = torque_in_zone(zone, start, contact)
    A = table.node_from_state
    linear = speed_reference + y[0] * row(A, 0, NODES) + y[1] * row(A, 1, NODES) + y[2] * row(A, 2, NODES)
    linear = linear + y[3] * row(A, 3, NODES)
    rest = y[4] * row(A, 4, NODES) + y[5] * row(A, 5, NODES) + y[6] * row(A, 6, NODES)
    store(work.linear, 0, linear + rest)
    if contact.tilt > 0.0:
        _begin_tilted(start, torque, slope, contact, table, work)
        torque *= 1.0 + work.cosine
    else:
        for j in range(NODES):
            work.speed[j], work.torque[j], work.slope[j] = start, torque, slope
    for _ in range(_NEWTON_LIMIT):
        change, largest = _newton_step(table, work)
        near = 0.5 * contact.v_b * change * work.caution < ladder.newton_tolerance
        # Far from where the law was linearised its slope there tells nothing: where friction had long fallen, it was 0.
        near = near and contact.v_b * largest < _FARTHEST
        if contact.law != EXPONENTIAL and zone != 0:
            near = _meets_law(zone, contact, ladder, work)
        near |= zone == 0
        if contact.tilt > 0.0:
            near &= turn_nodes(start, contact, work) * work.caution < _OF_DEFECT * ladder.largest_defect
        if near:
            return reach_of(y, start, torque, zone, contact, ladder, rung, work)
        for j in range(NODES):
            if not fine and zone * work.speed[j] < omega_s - ladder.clearly_beyond:
                return crossing(start, zone, contact, fine, work)
            work.torque[j], work.slope[j] = torque_in_zone(zone, work.speed[j], contact)
            if contact.tilt > 0.0:
                work.torque[j], work.slope[j] = work.factor[j] * work.torque[j], work.factor[j] * work.slope[j]
    return 0.0


@inlined
def _begin_tilted(start: float, torque: float, slope: float, contact: Record, table: Record, work: Record) -> None:
    """What Newton's method begins with on a tilted disc: it turns as the torque at the start would let it."""
    A = table.node_from_torque
    begun = torque * (1.0 + work.cosine)
    for j in range(NODES):
        work.speed[j] = work.linear[j] + begun * (A[j, 0] + A[j, 1] + A[j, 2] + A[j, 3])
    turn_nodes(start, contact, work)
    for j in range(NODES):
        work.speed[j], work.torque[j] = start, work.factor[j] * torque
        work.slope[j] = work.factor[j] * slope


@compiled
def _meets_law(zone: int, contact: Record, ladder: Record, work: Record) -> bool:
    """Whether the linearised T_r1 at every node is that of the law at the speed found there."""
    off = 0.0
    for j in range(NODES):
        torque, _ = torque_in_zone(zone, work.speed[j], contact)
        if contact.tilt > 0.0:
            torque *= work.factor[j]
        off = max(off, abs(torque - work.torque[j])) if contact.law != LINEAR else 0.0
    return bool(off * work.caution < ladder.newton_tolerance)


@inlined
def _newton_step(table: Record, work: Record) -> tuple[float, float]:
    """One Newton step for speed = linear + node_from_torque @ torque(speed).

    Returns the largest slope times step^2 (N m rad/s), a measure of what the next step would change, and the largest
    step (rad/s).
    The system (1 - A diag(slope)) step = residual is solved by elimination in blocks of two, without
    pivots: the matrix is the identity plus a Radau matrix.
    """
    A, speed, torque, slope = table.node_from_torque, work.speed, work.torque, work.slope
    T_0, T_1, T_2, T_3 = torque[0], torque[1], torque[2], torque[3]
    s_0, s_1, s_2, s_3 = slope[0], slope[1], slope[2], slope[3]
    r_0 = work.linear[0] - speed[0] + (A[0, 0] * T_0 + A[0, 1] * T_1 + A[0, 2] * T_2 + A[0, 3] * T_3)
    r_1 = work.linear[1] - speed[1] + (A[1, 0] * T_0 + A[1, 1] * T_1 + A[1, 2] * T_2 + A[1, 3] * T_3)
    r_2 = work.linear[2] - speed[2] + (A[2, 0] * T_0 + A[2, 1] * T_1 + A[2, 2] * T_2 + A[2, 3] * T_3)
    r_3 = work.linear[3] - speed[3] + (A[3, 0] * T_0 + A[3, 1] * T_1 + A[3, 2] * T_2 + A[3, 3] * T_3)
    # Upper rows (p q | f g), lower rows (u v | m n).
    p_0, q_0, f_0, g_0 = 1.0 - A[0, 0] * s_0, -A[0, 1] * s_1, -A[0, 2] * s_2, -A[0, 3] * s_3
    p_1, q_1, f_1, g_1 = -A[1, 0] * s_0, 1.0 - A[1, 1] * s_1, -A[1, 2] * s_2, -A[1, 3] * s_3
    u_2, v_2, m_2, n_2 = -A[2, 0] * s_0, -A[2, 1] * s_1, 1.0 - A[2, 2] * s_2, -A[2, 3] * s_3
    u_3, v_3, m_3, n_3 = -A[3, 0] * s_0, -A[3, 1] * s_1, -A[3, 2] * s_2, 1.0 - A[3, 3] * s_3
    inverse = 1.0 / (p_0 * q_1 - p_1 * q_0)
    f_0, f_1 = inverse * (q_1 * f_0 - q_0 * f_1), inverse * (p_0 * f_1 - p_1 * f_0)
    g_0, g_1 = inverse * (q_1 * g_0 - q_0 * g_1), inverse * (p_0 * g_1 - p_1 * g_0)
    r_0, r_1 = inverse * (q_1 * r_0 - q_0 * r_1), inverse * (p_0 * r_1 - p_1 * r_0)
    m_2, n_2, r_2 = m_2 - u_2 * f_0 - v_2 * f_1, n_2 - u_2 * g_0 - v_2 * g_1, r_2 - u_2 * r_0 - v_2 * r_1
    m_3, n_3, r_3 = m_3 - u_3 * f_0 - v_3 * f_1, n_3 - u_3 * g_0 - v_3 * g_1, r_3 - u_3 * r_0 - v_3 * r_1
    inverse = 1.0 / (m_2 * n_3 - m_3 * n_2)
    r_2, r_3 = inverse * (n_3 * r_2 - n_2 * r_3), inverse * (m_2 * r_3 - m_3 * r_2)
    r_0, r_1 = r_0 - f_0 * r_2 - g_0 * r_3, r_1 - f_1 * r_2 - g_1 * r_3
    speed[0], speed[1], speed[2], speed[3] = speed[0] + r_0, speed[1] + r_1, speed[2] + r_2, speed[3] + r_3
    torque[0], torque[1], torque[2], torque[3] = T_0 + s_0 * r_0, T_1 + s_1 * r_1, T_2 + s_2 * r_2, T_3 + s_3 * r_3
    upper = max(abs(s_0 * r_0 * r_0), abs(s_1 * r_1 * r_1))
    change = max(upper, max(abs(s_2 * r_2 * r_2), abs(s_3 * r_3 * r_3)))
    return change, max(max(abs(r_0), abs(r_1)), max(abs(r_2), abs(r_3)))


@inlined
def take_step(y: FloatArray, table: Record, work: Record) -> None:
    """Take a solved step as a whole: the state at its end, in place."""
    evaluate(y, work, table.state_from_state, table.state_from_torque, (0, 1), 0.0, y, 0, STATE)


@inlined
def evaluate(
    y: FloatArray,
    work: Record,
    from_state: FloatArray,
    from_torque: FloatArray,
    rows: tuple[int, int],
    constant: float,
    out: FloatArray,
    first: int,
    count: int,
) -> None:
    """Quantities of a solved step as entries `first` and on of `out`: constant + y @ from_state + T_r1 @ from_torque.

    `count`, how many they are, is a constant. `rows` tells what comes before the first row of the tables, in rows, and
    how far apart rows are, in rows of an array of two axes or in entries of one.
    """
    A, b, T = from_state, from_torque, work.torque
    before, apart = rows
    i, j = 7 * before, NODES * before
    free = constant + y[0] * row(A, i, count) + y[1] * row(A, i + apart, count) + y[2] * row(A, i + 2 * apart, count)
    free = free + y[3] * row(A, i + 3 * apart, count) + y[4] * row(A, i + 4 * apart, count)
    forced = T[0] * row(b, j, count) + T[1] * row(b, j + apart, count) + T[2] * row(b, j + 2 * apart, count)
    forced = forced + T[3] * row(b, j + 3 * apart, count)
    free = free + y[5] * row(A, i + 5 * apart, count)
    store(out, first, free + (y[6] * row(A, i + 6 * apart, count) + forced))
