"""State feedback about steady rotation at a set-point, for a rig whose friction is known.

About steady rotation the rig is linear but for the slope Delta T_r1 of its friction (4-21), so one family
of LQ gains over the slope serves every load, friction and speed:

    change of omega_ref in a control step = - gain(slope) (z - z_steady),   z = (x, omega_ref),

with the gain that is least in the sum of (x_3 - set-point)^2 + effort (change of omega_ref)^2 for the
sampled model. It holds rotation below omega_c too, where the bare drive cannot. Rigs of a fleet have such a family
each.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from baselines.sampled import over_a_step, riccati
from drillrig_env.arrays import FloatArray
from drillrig_env.fleet import side_by_side
from drillrig_env.friction import Friction
from drillrig_env.model import jacobian, state_equations, steady_state
from drillrig_env.rig import Rig
from drillrig_env.scales import CONTROL_PERIOD
from drillrig_env.stability import critical_slope

SIZE = 8
"""Length of z: the 7 states and the speed reference."""

_STEEPEST = 64.0  # largest slope of the table, in critical slopes; steeper friction gets its gain
_REGULAR = 1e-6  # weight of all of z beside the bit speed, so that the Riccati equation has a solution


class SetPointFeedback:
    """Gains and levels of the feedback of some rigs at any set-point, each `period` (s).

    `effort` weighs the squared change of omega_ref; `entries` are the slopes between which gains are interpolated.
    """

    def __init__(self, rigs: Sequence[Rig], effort: float, period: float = CONTROL_PERIOD, entries: int = 161) -> None:
        self.rigs = side_by_side(rigs)
        self.tables = np.stack([_gains(rig, effort, period, entries) for rig in rigs])
        self._steepest = np.array([_STEEPEST * abs(critical_slope(rig)) for rig in rigs])

    def at(self, friction: Friction, set_point: FloatArray, places: int | npt.NDArray[np.intp] = 0) -> FloatArray:
        """The feedback at set-points (rad/s) of shape s, for the rigs at `places`; shape (*s, SIZE + 1).

        The first SIZE columns are the gain, the last one the level: the wanted change of omega_ref
        is level - gain z. The friction's fields and the places broadcast with the set-points.
        """
        rigs, last = self.rigs[places], self.tables.shape[1] - 1
        place = np.sqrt(np.clip(-np.asarray(friction.slope(rigs, set_point)) / self._steepest[places], 0.0, 1.0))
        place *= last
        below = np.minimum(place.astype(int), last - 1)
        share = (place - below)[..., None]
        found = np.empty((*np.shape(set_point), SIZE + 1))
        gain = found[..., :SIZE]
        gain[...] = (1.0 - share) * self.tables[places, below] + share * self.tables[places, below + 1]
        steady = steady_state(rigs, friction, set_point)
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


@lru_cache(maxsize=512)
def _gains(rig: Rig, effort: float, period: float, entries: int) -> FloatArray:
    """Gains for friction slopes from 0 down to the steepest, at even steps of the slope's root; (entries, SIZE)."""
    slopes = -_STEEPEST * abs(critical_slope(rig)) * np.linspace(0.0, 1.0, entries) ** 2
    cost = _REGULAR * np.eye(SIZE)
    cost[2, 2] = 1.0
    table = np.empty((entries, SIZE))
    for i, slope in enumerate(slopes):
        transition, by_change = _sampled(rig, float(slope), period)
        price = riccati(transition, by_change, cost, np.array([[effort]]))
        table[i] = (by_change.T @ price @ transition / (effort + by_change.T @ price @ by_change))[0]
    table.flags.writeable = False
    return table


def _sampled(rig: Rig, slope: float, period: float) -> tuple[FloatArray, FloatArray]:
    """One control step of z about steady rotation: z(k+1) = A z(k) + B change; shapes (SIZE, SIZE), (SIZE, 1)."""
    zero = [0.0] * 7
    rates = np.zeros((SIZE, SIZE))
    rates[:7, :7] = jacobian(rig, slope)
    rates[:7, 7] = np.subtract(state_equations(zero, 1.0, 0.0, rig), state_equations(zero, 0.0, 0.0, rig))
    transition = over_a_step(rates, period)
    return transition, transition[:, 7:].copy()
