"""Variation of constants as tables: the state within a step from the state at its start and the torque at the nodes.

The integrals against the powers of time come out of the exponential of one augmented matrix; the inverse Vandermonde
matrix of the nodes turns them into integrals against the interpolating polynomial.

A matrix with fast modes needs care. SciPy's `expm` halves it until its norm is about 1 and squares the result as often
again: from 1 + a little, where the little keeps few digits. Modes of 1e9 1/s, such as an armature without inductance,
cost it half of them. What is squared here is exp(A) - 1, by exp(2 A) - 1 = 2 (exp(A) - 1) + (exp(A) - 1)^2,
which keeps them all, and every squaring is a rung of the ladder.
"""

from __future__ import annotations

from math import factorial

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import expm

from drillrig_env.arrays import FloatArray

NODES = 4


def _radau_nodes(count: int) -> FloatArray:
    """The right Radau nodes on (0, 1], the last one being 1: roots of P_n - P_(n-1)."""
    roots = np.sort(legendre.legroots([0.0] * (count - 1) + [-1.0, 1.0]).real)
    roots[-1] = 1.0
    return np.asarray((roots + 1.0) / 2.0)


RADAU_NODES = _radau_nodes(NODES)
POWERS_FROM_NODES = np.linalg.inv(np.vander(RADAU_NODES, increasing=True))
"""Coefficients of 1, s, s^2, s^3 of the cubic through the node values, over a step of length 1."""

BETWEEN = np.array([0.04, 0.24, 0.6, 0.9])
"""Fractions of a step between the nodes, where friction that makes errors grow is looked at once more."""

_LARGEST_NORM = 1e3
"""The largest norm of a matrix times a step whose exponential `expm` takes."""

_SMALL_NORM, _SERIES = 0.25, 12
"""A norm whose series ends, to rounding, with so many terms."""


def variation_of_constants(
    M: FloatArray, b: FloatArray, step: float, times: FloatArray, rungs: int = 1
) -> tuple[FloatArray, FloatArray]:
    """State of y' = M y + b T at the fractions `times` of a step, from the state at its start and T at the nodes.

    Returns arrays of shape (rungs, times, 7, 7) and (rungs, times, 7, NODES), for `rungs` steps, each half of the one
    before. However fast the modes of M are, all digits are kept.
    """
    norm = np.abs(M).sum(axis=1).max() * step
    fast = int(np.count_nonzero(norm / 2.0 ** np.arange(rungs) > _LARGEST_NORM))
    taken = [_taken(M, b, step / 2**rung, times) for rung in range(fast, rungs)]
    doubled = zip(*doubled_steps(M, b, step, times, fast), strict=True) if fast else ()
    from_state, from_torque = zip(*doubled, *taken, strict=True)
    return np.stack(from_state), np.stack(from_torque)


def _taken(M: FloatArray, b: FloatArray, step: float, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same for one step, by `expm`."""
    exponentials = expm(_augmented(M * step, b * step) * times[:, None, None])
    powers = exponentials[:, :7, 7:] * [factorial(k) for k in range(NODES)]
    return exponentials[:, :7, :7], powers @ POWERS_FROM_NODES


def _augmented(M: FloatArray, b: FloatArray) -> FloatArray:
    """The matrix whose exponential holds the integrals of b against 1, s, s^2 / 2, s^3 / 6 beside that of M."""
    augmented = np.zeros((7 + NODES, 7 + NODES))
    augmented[:7, :7], augmented[:7, 7] = M, b
    augmented[range(7, 6 + NODES), range(8, 7 + NODES)] = 1.0
    return augmented


def doubled_steps(
    M: FloatArray, b: FloatArray, step: float, times: FloatArray, rungs: int
) -> tuple[FloatArray, FloatArray]:
    """As `variation_of_constants`, by doubling: all steps in one go, to rounding.

    Damping between two discs, as fast as that, rounds what they do in common: where modes are fast, digits are longer.
    """
    augmented = _augmented(M, b)
    norm = np.abs(augmented).sum(axis=1).max() * step
    halvings = max(rungs - 1, int(np.ceil(np.log2(norm / _SMALL_NORM))))
    augmented = augmented.astype(np.longdouble) if norm > _LARGEST_NORM else augmented
    small = augmented * (times * (step / 2.0**halvings))[:, None, None]
    less_one, term = small, small
    for order in range(2, _SERIES + 1):
        term = term @ small / order
        less_one = less_one + term
    from_state, from_torque = np.empty((rungs, len(times), 7, 7)), np.empty((rungs, len(times), 7, NODES))
    for rung in range(halvings, -1, -1):
        if rung < rungs:
            from_state[rung] = less_one[:, :7, :7] + np.eye(7)
            share_of_power = [factorial(k) / (step / 2.0**rung) ** k for k in range(NODES)]
            from_torque[rung] = less_one[:, :7, 7:] * share_of_power @ POWERS_FROM_NODES
        less_one = 2.0 * less_one + less_one @ less_one
    return from_state, from_torque
