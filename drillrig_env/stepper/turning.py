"""A normal force that varies as disc 1 turns, within a step: N_1 (1 + a cos(m theta_1 + phi)).

theta_1 needs no state of its own: theta_3 is the integral of x_5, which the drive's integrator knows, so that

    theta_1 = integral of omega_ref + x_1 + x_2 - x_7, and a constant.

Within a step it is the integral of the quartic through the bit speed at the start and at the nodes. As it hardly
depends on the friction torque, Newton's method takes it from the iteration before, until it no longer changes.
"""

from __future__ import annotations

from math import cos, factorial, inf, sin

import numpy as np

from drillrig_env.arrays import FloatArray, Record
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.jit.simd import row, store
from drillrig_env.stepper.exponentials import BETWEEN, NODES, POWERS_FROM_NODES, RADAU_NODES

LARGEST_TURN = 1.5
"""How far m theta_1 may turn within a step, rad: nodes see no more of its cosine."""

SMALL_TURN = 0.5
"""How far it may turn with the start of the step as the only place where the nodes are put to the proof."""

_POWERS_OF_RATES = POWERS_FROM_NODES / RADAU_NODES


def _integrals(times: FloatArray) -> FloatArray:
    """The integral of the quartic up to `times`, but for that of its start, from the speeds at the nodes less that."""
    exponents = np.arange(2, NODES + 2)
    return np.asarray(times[:, None] ** exponents / exponents) @ _POWERS_OF_RATES


_TO_NODES, _TO_BETWEEN = (np.ascontiguousarray(_integrals(times).T) for times in (RADAU_NODES, BETWEEN))
"""A row for the speed at each node, an entry for each time."""

_ORDER = 8
_COSINE = np.array([(-1.0) ** k / factorial(2 * k) for k in range(_ORDER, -1, -1)])
_SINE = np.array([(-1.0) ** k / factorial(2 * k + 1) for k in range(_ORDER, -1, -1)])
"""Taylor's coefficients of cos x, and of sin x / x, in powers of x^2: to rounding up to LARGEST_TURN."""


@inlined
def begin_turning(y: FloatArray, contact: Record, work: Record) -> None:
    """Find how the disc presses at the start of a step, `work.elapsed` s after the start of the period."""
    turned = contact.speed_reference * work.elapsed + (y[0] + y[1] - y[6])
    angle = contact.angle + contact.turns * turned
    work.cosine, work.sine = contact.tilt * cos(angle), contact.tilt * sin(angle)


@inlined
def turn_nodes(start: float, contact: Record, work: Record) -> float:
    """Find `work.factor` at the nodes from their speeds; by how much torques were wrong with those before (N m).

    `start` is the bit speed at the start of the step. Infinite where the disc turns too far in the step, and nothing is
    known then.
    """
    for j in range(NODES):
        work.before_turning[j] = work.factor[j]
    _turn(start, RADAU_NODES, _TO_NODES, contact, work, work.factor)
    wrong, farthest = 0.0, 0.0
    for j in range(NODES):
        change = abs(work.factor[j] - work.before_turning[j])
        wrong = max(wrong, change * max(contact.static, abs(work.torque[j])))
        farthest = max(farthest, abs(work.angle[j]))
    work.turned = farthest
    return wrong if farthest <= LARGEST_TURN else inf


@compiled
def turn_between(start: float, contact: Record, work: Record) -> None:
    """Find by which the disc presses more than N_1 at the times between the nodes, as `work.between_factor`."""
    _turn(start, BETWEEN, _TO_BETWEEN, contact, work, work.between_factor)


@inlined
def _turn(
    start: float, times: FloatArray, from_speeds: FloatArray, contact: Record, work: Record, factor: FloatArray
) -> None:
    """By which the disc presses more than N_1 at some `times`, to which m theta_1 turns by `work.angle` (rad)."""
    v = work.speed
    turned = start * row(times, 0, NODES) + (v[0] - start) * row(from_speeds, 0, NODES)
    turned = turned + (v[1] - start) * row(from_speeds, 1, NODES) + (v[2] - start) * row(from_speeds, 2, NODES)
    turned = (contact.turns * work.length) * (turned + (v[3] - start) * row(from_speeds, 3, NODES))
    square = turned * turned
    cosine, sine = _COSINE[1] + _COSINE[0] * square, _SINE[1] + _SINE[0] * square
    for k in range(2, _ORDER + 1):
        cosine, sine = _COSINE[k] + cosine * square, _SINE[k] + sine * square
    store(work.angle, 0, turned)
    store(factor, 0, 1.0 + (work.cosine * cosine + (-work.sine) * (turned * sine)))
