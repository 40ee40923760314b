"""The linear rig, sampled once a control step: what a filter and a feedback are designed on.

The model (4-17) is linear but for the friction torque T_r1 on the bit. About rotation at the target it is taken as

    T_r1 = T_0 + T_w - s (x_3 - omega*),

a level T_0 that wanders slowly (a random walk), a fluctuation T_w that is forgotten within seconds, and a fixed
slope -s that stands for the weakening of the friction with speed. The design state z of length 10 is

    z = (x - x_f, T_0, T_w, T_m),

with x_f the frictionless rotation at omega* and T_m the mean torque into the string over the last control
step, which is what a drive reports, less T_r2, which x_f carries. A drive that takes the rig for another reports what
`drillrig_env.model.estimate_of_torque` says, and T_m is that. The speed reference is held over a step, so
the sampled model is exact.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp, sqrt

import numpy as np

from baselines.sampled import over_a_step, riccati
from drillrig_env.arrays import FloatArray
from drillrig_env.model import (
    STATE_NAMES,
    estimate_of_torque,
    friction_input,
    frictionless_state,
    jacobian,
    torque_into_string,
)
from drillrig_env.rig import Rig
from drillrig_env.scales import CONTROL_PERIOD

LEVEL, FLUCTUATION, MEAN_TORQUE, SIZE = 7, 8, 9, 10
"""Places in z of T_0, T_w and T_m, and the length of z."""

MEASURED = (*STATE_NAMES, "voltage", "string_torque")
"""The channels that are linear in z and the speed reference."""


@dataclass(frozen=True, eq=False)
class LinearRig:
    """z(k+1) = transition z(k) + input r(k), with r = omega_ref - omega* held over the step.

    `slope` is s in N m s/rad, `forgotten` the time in s within which T_w is forgotten, `period` that of a step in s.
    `nominal` is the rig that the drive takes it for, None the rig itself.
    """

    rig: Rig
    slope: float
    forgotten: float
    period: float = CONTROL_PERIOD
    nominal: Rig | None = None
    transition: FloatArray = field(init=False)  # (SIZE, SIZE)
    input: FloatArray = field(init=False)  # (SIZE,)

    def __post_init__(self) -> None:
        rates = np.zeros((SIZE + 1, SIZE + 1))  # of z and, in the last column, r
        rates[:7, :7] = jacobian(self.rig, -self.slope)
        rates[:7, LEVEL] = rates[:7, FLUCTUATION] = friction_input(self.rig)
        rates[FLUCTUATION, FLUCTUATION] = -1.0 / self.forgotten
        rates[:7, SIZE] = -jacobian(self.rig) @ self.per_speed
        gain, per_speed, per_rate, _ = self._estimated
        rates[MEAN_TORQUE, :7] = gain * torque_into_string(self.rig, np.eye(7)) / self.period
        rates[MEAN_TORQUE, 4] += per_speed / self.period
        rates[MEAN_TORQUE] += per_rate / self.period * rates[4]
        sampled = over_a_step(rates, self.period)
        transition = sampled[:SIZE, :SIZE].copy()
        transition[:, MEAN_TORQUE] = 0.0  # each step's mean begins anew
        object.__setattr__(self, "transition", transition)
        object.__setattr__(self, "input", sampled[:SIZE, SIZE].copy())

    @property
    def _estimated(self) -> tuple[float, float, float, float]:
        return estimate_of_torque(self.rig, self.nominal or self.rig)

    @property
    def per_speed(self) -> FloatArray:
        """How the frictionless rotation x_f grows with its speed, shape (7,)."""
        return np.asarray(frictionless_state(self.rig, 1.0) - frictionless_state(self.rig, 0.0))

    @property
    def per_level(self) -> FloatArray:
        """How z in steady rotation at omega* grows with T_0, shape (SIZE,)."""
        rig = self.rig
        z = np.zeros(SIZE)
        z[0], z[1], z[LEVEL], z[MEAN_TORQUE] = -1.0 / rig.k_1, -1.0 / rig.k_2, 1.0, self._estimated[0]
        z[5] = 1.0 / (rig.eta * rig.K_T)
        z[6] = rig.R * z[5] / rig.k_i
        return z

    def measurement(self, channel: str) -> tuple[FloatArray, float]:
        """A channel's row on z, and its factor on r."""
        row, through = np.zeros(SIZE), 0.0
        if channel == "voltage":
            row[4], row[6], through = -self.rig.k_p, self.rig.k_i, self.rig.k_p
        elif channel == "string_torque":
            row[MEAN_TORQUE] = 1.0
        else:
            row[STATE_NAMES.index(channel)] = 1.0
        return row, through

    def filter_gain(self, channels: tuple[str, ...], noise: FloatArray, level: float, fluctuation: float) -> FloatArray:
        """Gain of the steady-state Kalman filter, shape (SIZE, channels): z += gain (measured - expected).

        `noise` has the channels' standard deviations, `level` is that of the steps of T_0 in a second,
        `fluctuation` that of T_w, both in N m. Torques are taken to change when a step begins.
        """
        jumps = np.zeros(SIZE)
        jumps[LEVEL] = level * sqrt(self.period)
        jumps[FLUCTUATION] = fluctuation * sqrt(1.0 - exp(-2.0 * self.period / self.forgotten))
        spread = self.transition * jumps
        rows = np.stack([self.measurement(channel)[0] for channel in channels])
        seen = np.diag(np.square(noise))
        transition = self.transition.copy()
        transition[LEVEL, LEVEL] -= 1e-4  # speeds alone do not show the level: a leak, or there is no solution
        wander = spread @ spread.T + 1e-6 * np.eye(SIZE)  # the model is not quite true
        covariance = riccati(transition.T, rows.T, wander, seen)
        return gain_of(covariance, rows, seen)

    def feedback_gain(self, twisting: float, effort: float) -> FloatArray:
        """Gain of the LQ feedback, shape (SIZE + 1,): change of omega_ref a step = -gain (z - z_steady(T_0), r).

        It minimises the sum over all steps of (x_3 - omega*)^2 + `twisting` (x_4 - x_5)^2 + `effort` (change)^2.
        """
        kept = [i for i in range(SIZE) if i not in (LEVEL, MEAN_TORQUE)]
        n = len(kept)
        transition, by_change = np.eye(n + 1), np.ones((n + 1, 1))
        transition[:n, :n], transition[:n, n] = self.transition[np.ix_(kept, kept)], self.input[kept]
        by_change[:n, 0] = self.input[kept]
        cost = 1e-6 * np.eye(n + 1)
        cost[2, 2] += 1.0
        cost[3:5, 3:5] += twisting * np.array([[1.0, -1.0], [-1.0, 1.0]])
        price = riccati(transition, by_change, cost, np.array([[effort]]))
        gain = by_change.T @ price @ transition / (effort + by_change.T @ price @ by_change)
        full = np.zeros(SIZE + 1)
        full[[*kept, SIZE]] = gain[0]
        return full


def without_friction(rig: Rig, nominal: Rig, channel: str, speed: FloatArray) -> FloatArray:
    """What a channel shows in frictionless rotation at `speed` (rad/s), shape (n,), with a drive of the nominal rig.

    `rig` may be several, one for each speed, as `drillrig_env.fleet.side_by_side` has them.
    """
    x = frictionless_state(rig, speed)
    if channel == "voltage":
        return np.asarray(rig.k_i * x[..., 6])
    if channel == "string_torque":
        gain, per_speed, _, offset = estimate_of_torque(rig, nominal)
        return np.asarray(gain * torque_into_string(rig, x) + per_speed * speed + offset)
    return np.asarray(x[..., STATE_NAMES.index(channel)])


def gain_of(covariance: FloatArray, rows: FloatArray, noise: FloatArray) -> FloatArray:
    """How far a measurement with covariance `noise` moves an estimate with `covariance`; (SIZE, channels)."""
    shared = rows @ covariance
    return np.asarray(np.linalg.solve(shared @ rows.T + noise, shared).T)


def applied(matrix: FloatArray, vectors: FloatArray) -> FloatArray:
    """The products matrix @ v for each v of `vectors`, shape (n, columns): the same to the last bit whatever n is."""
    return np.asarray((vectors[:, None, :] * matrix).sum(axis=-1))
