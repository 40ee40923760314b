"""The states between two control steps, for the eye: what follows from the samples of bit speed within the step.

The stepper leaves SAMPLES of bit speed and string torque in each control step, and the states at its end. With the bit
speed known, all other states follow from it through the linear part of (4-17),

    dz/dt = A z + b x_3 + c omega_ref + d,      z = (x_1, x_2, x_4, x_5, x_6, x_7),

solved here once and for all with x_3 straight between its samples. What is left at the end of the step, where disc 2
sticks or a drive limits its current, is taken off in proportion to time: the lines pass through the environment's own
numbers at every control step.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from drillrig_env.arrays import FloatArray
from drillrig_env.env.task import Task
from drillrig_env.model import equilibrium, jacobian
from drillrig_env.stepper.ladder import SAMPLES

_REST = (0, 1, 3, 4, 5, 6)
"""The states but for the bit speed."""

_SHARES = np.arange(1, SAMPLES + 1) / SAMPLES


class Between:
    """The states within the control steps of a task, at the SAMPLES of the stepper."""

    def __init__(self, task: Task) -> None:
        rig, drive = task.rig, task.drive
        full = jacobian(rig, drive=drive)
        rest, n = list(_REST), len(_REST)
        A, b = full[np.ix_(rest, rest)], full[rest, 2]
        c = np.zeros(7)
        loop = task.speed_loop
        c[5], c[6] = loop.k_p / rig.L, 1.0
        still = equilibrium(rig, 0.0, 0.0, drive)  # what is constant in (4-17), from a state that it holds
        d = -(full @ still)[rest]
        step = task.control_period / SAMPLES
        # One step with x_3 going straight from `u` to `u + v`: the states of x_3, and of the constants, beside z.
        linear = np.zeros((n + 4, n + 4))
        linear[:n, :n], linear[:n, n] = A, b
        linear[n, n + 1] = 1.0 / step
        linear[:n, n + 2], linear[:n, n + 3] = c[rest], d
        one = expm(linear * step)
        # All samples at once, from z at the start, the SAMPLES + 1 bit speeds, omega_ref and 1.
        width = n + SAMPLES + 3
        row = np.zeros((n, width))
        row[:, :n] = np.eye(n)
        rows = []
        for k in range(SAMPLES):
            row = one[:n, :n] @ row
            row[:, n + k] += one[:n, n] - one[:n, n + 1]
            row[:, n + k + 1] += one[:n, n + 1]
            row[:, -2] += one[:n, n + 2]
            row[:, -1] += one[:n, n + 3]
            rows.append(row)
        self._all = np.concatenate(rows)
        self._given = np.ones(width)

    def states(self, before: FloatArray, after: FloatArray, speeds: FloatArray, speed_reference: float) -> FloatArray:
        """States of shape (7, SAMPLES) within a control step.

        `before` and `after` are the 7 states at its start and its end, `speeds` the SAMPLES of bit speed (rad/s), the
        last one at the end, and `speed_reference` (rad/s) is that of the step.
        """
        n = len(_REST)
        given = self._given
        given[:n] = before[list(_REST)]
        given[n], given[n + 1 : n + 1 + SAMPLES], given[-2] = before[2], speeds, speed_reference
        found = (self._all @ given).reshape(SAMPLES, n)
        found += _SHARES[:, None] * (after[list(_REST)] - found[-1])
        states = np.empty((7, SAMPLES))
        states[list(_REST)], states[2] = found.T, speeds
        return states
