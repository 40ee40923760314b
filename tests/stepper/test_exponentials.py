"""Exponentials of matrices with fast modes, against 60 digits."""

import mpmath
import numpy as np
import pytest

from drillrig_env import Rig
from drillrig_env.model import friction_input, jacobian
from drillrig_env.stepper.exponentials import (
    NODES,
    POWERS_FROM_NODES,
    RADAU_NODES,
    doubled_steps,
    variation_of_constants,
)


def exact(rig, step):
    """State from state and from the powers of time, of y' = M y + b s^k at the end of a step, with 60 digits."""
    with mpmath.workdps(60):
        augmented = mpmath.matrix(7 + NODES, 7 + NODES)
        for i, row in enumerate(jacobian(rig)):
            for j, entry in enumerate(row):
                augmented[i, j] = mpmath.mpf(entry) * step
            augmented[i, 7] = mpmath.mpf(friction_input(rig)[i]) * step
        for k in range(NODES - 1):
            augmented[7 + k, 8 + k] = 1
        full = np.array(mpmath.expm(augmented).tolist(), dtype=float)
    return full[:7, :7], full[:7, 7:] * [1.0, 1.0, 2.0, 6.0] @ POWERS_FROM_NODES


@pytest.mark.parametrize("rig", [Rig(), Rig(L=2e-9), Rig(L=7e-12), Rig(J_2=3e-9), Rig(d_1=4e5), Rig(k_1=3e9)])
@pytest.mark.parametrize("step", [0.1, 3e-5])
def test_all_digits_are_kept_however_fast_a_mode_is(rig, step):
    from_state, from_torque = variation_of_constants(jacobian(rig), friction_input(rig), step, RADAU_NODES)
    for found, expected in zip((from_state[0, -1], from_torque[0, -1]), exact(rig, step), strict=True):
        scale = np.maximum(np.abs(expected).max(axis=1, keepdims=True), 1e-12)
        assert np.abs((found - expected) / scale)[:5].max() < 3e-12


def test_rungs_are_halves_of_one_another():
    M, b = jacobian(Rig(R=40.0)), friction_input(Rig(R=40.0))
    ladder = doubled_steps(M, b, 0.07, RADAU_NODES, 9)
    for rung in (0, 3, 8):
        alone = variation_of_constants(M, b, 0.07 / 2**rung, RADAU_NODES)
        for found, expected in zip(ladder, alone, strict=True):
            np.testing.assert_allclose(found[rung], expected[0], rtol=1e-11, atol=1e-13)
