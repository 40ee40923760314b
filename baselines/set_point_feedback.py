"""State feedback about steady rotation at a set-point, for a rig whose friction is known.

About steady rotation the rig is linear but for the slope Delta T_r1 of its friction (4-21), so one family
of LQ gains over the slope serves every load, friction and speed:

    change of omega_ref in a control step = - gain(slope) (z - z_steady),   z = (x, omega_ref),

with the gain that is least in the sum of (x_3 - set-point)^2 + effort (change of omega_ref)^2 for the
sampled model. It holds rotation below omega_c too, where the bare drive cannot.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.model import jacobian, state_equations, steady_state
from drillrig_env.rig import Rig
from drillrig_env.scales import CONTROL_PERIOD
from drillrig_env.stability import critical_slope

SIZE = 8
"""Length of z: the 7 states and the speed reference."""

_STEEPEST = 64.0  # largest slope of the table, in critical slopes; steeper friction gets its gain
_ENTRIES = 161
_REGULAR = 1e-6  # weight of all of z beside the bit speed, so that the Riccati equation has a solution


class SetPointFeedback:
    """Gains and levels of the feedback at any set-point, each `period` (s).

    `effort` weighs the squared change of omega_ref.
    """

    def __init__(self, rig: Rig, effort: float, period: float = CONTROL_PERIOD) -> None:
        self.rig = rig
        self.table = _gains(rig, effort, period)
        self._steepest = _STEEPEST * abs(critical_slope(rig))

    def at(self, friction: Friction, set_point: FloatArray) -> FloatArray:
        """The feedback at set-points (rad/s) of shape s; shape (*s, SIZE + 1).

        The first SIZE columns are the gain, the last one the level: the wanted change of omega_ref
        is level - gain z. The friction's fields broadcast with the set-points.
        """
        place = np.sqrt(np.clip(-np.asarray(friction.slope(self.rig, set_point)) / self._steepest, 0.0, 1.0))
        place *= _ENTRIES - 1
        below = np.minimum(place.astype(int), _ENTRIES - 2)
        share = (place - below)[..., None]
        found = np.empty((*np.shape(set_point), SIZE + 1))
        gain = found[..., :SIZE]
        gain[...] = (1.0 - share) * self.table[below] + share * self.table[below + 1]
        steady = steady_state(self.rig, friction, set_point)
        found[..., SIZE] = (gain[..., :7] * steady).sum(axis=-1) + gain[..., 7] * set_point
        return found


def wanted_change(feedback: FloatArray, states: FloatArray, reference: FloatArray) -> FloatArray:
    """The change of omega_ref (rad/s) that rows of feedback ask for; shape (n,).

    `feedback` has shape (n, SIZE + 1), `states` (n, 7 or more) and `reference` (n,).
    """
    change = feedback[:, SIZE] - feedback[:, 7] * reference
    for i in range(7):
        change -= feedback[:, i] * states[:, i]
    return np.asarray(change)


@lru_cache(maxsize=8)
def _gains(rig: Rig, effort: float, period: float) -> FloatArray:
    """Gains for friction slopes from 0 down to the steepest, at even steps of the slope's root; (_ENTRIES, SIZE)."""
    slopes = -_STEEPEST * abs(critical_slope(rig)) * np.linspace(0.0, 1.0, _ENTRIES) ** 2
    cost = _REGULAR * np.eye(SIZE)
    cost[2, 2] = 1.0
    table = np.empty((_ENTRIES, SIZE))
    for i, slope in enumerate(slopes):
        transition, by_change = _sampled(rig, float(slope), period)
        price = solve_discrete_are(transition, by_change, cost, np.array([[effort]]))
        table[i] = (by_change.T @ price @ transition / (effort + by_change.T @ price @ by_change))[0]
    table.flags.writeable = False
    return table


def _sampled(rig: Rig, slope: float, period: float) -> tuple[FloatArray, FloatArray]:
    """One control step of z about steady rotation: z(k+1) = A z(k) + B change; shapes (SIZE, SIZE), (SIZE, 1)."""
    zero = [0.0] * 7
    rates = np.zeros((SIZE, SIZE))
    rates[:7, :7] = jacobian(rig, slope)
    rates[:7, 7] = np.subtract(state_equations(zero, 1.0, 0.0, rig), state_equations(zero, 0.0, 0.0, rig))
    transition = expm(rates * period)
    return transition, transition[:, 7:].copy()
