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


_TO_NODES, _TO_BETWEEN = _integrals(RADAU_NODES), _integrals(BETWEEN)

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
def _factor(turned: float, work: Record) -> float:
    """By which the disc presses more than N_1 where m theta_1 has `turned` (rad) since the start of the step."""
    square, cosine, sine = turned * turned, 0.0, 0.0
    for k in range(_ORDER + 1):
        cosine = cosine * square + _COSINE[k]
        sine = sine * square + _SINE[k]
    factor: float = 1.0 + (work.cosine * cosine - work.sine * (turned * sine))
    return factor


@inlined
def turn_nodes(start: float, contact: Record, work: Record) -> float:
    """Find `work.factor` at the nodes from their speeds; by how much torques were wrong with those before (N m).

    `start` is the bit speed at the start of the step. Infinite where the disc turns too far in the step, and nothing is
    known then.
    """
    wrong, farthest, per_step = 0.0, 0.0, contact.turns * work.length
    for j in range(NODES):
        turned = start * RADAU_NODES[j]
        for k in range(NODES):
            turned += _TO_NODES[j, k] * (work.speed[k] - start)
        turned *= per_step
        factor = _factor(turned, work)
        wrong = max(wrong, abs(factor - work.factor[j]) * max(contact.static, abs(work.torque[j])))
        work.factor[j] = factor
        farthest = max(farthest, abs(turned))
    work.turned = farthest
    return wrong if farthest <= LARGEST_TURN else inf


@compiled
def factor_between(i: int, start: float, contact: Record, work: Record) -> float:
    """By which the disc presses more than N_1 at the time `i` between the nodes."""
    turned = start * BETWEEN[i]
    for k in range(NODES):
        turned += _TO_BETWEEN[i, k] * (work.speed[k] - start)
    return _factor(contact.turns * work.length * turned, work)
