"""The linear model over a step and its Riccati equation, against what they are defined by; and rigs without either."""

import warnings

import numpy as np
import pytest

from baselines.lqg import LQG
from baselines.sampled import over_a_step, riccati
from drillrig_env.rig import Rig


def test_a_step_of_an_oscillator_turns_its_state():
    found = over_a_step(np.array([[0.0, 2.0], [-2.0, 0.0]]), 0.3)
    np.testing.assert_allclose(found, [[np.cos(0.6), np.sin(0.6)], [-np.sin(0.6), np.cos(0.6)]], rtol=1e-12)


def test_the_riccati_equation_holds():
    A, B, Q, R = np.array([[1.1, 0.2], [0.0, 0.9]]), np.array([[0.0], [1.0]]), np.eye(2), np.array([[2.0]])
    X = riccati(A, B, Q, R)
    gain = np.linalg.solve(R + B.T @ X @ B, B.T @ X @ A)
    np.testing.assert_allclose(X, A.T @ X @ (A - B @ gain) + Q, rtol=1e-9)


def test_a_mode_that_cannot_be_moved_has_no_solution():
    with pytest.raises(FloatingPointError, match="its Riccati equation has no solution"):
        riccati(np.diag([1.5, 0.5]), np.array([[0.0], [1.0]]), np.eye(2), np.eye(1))


def test_a_rig_that_is_too_fast_for_its_period_is_told_of_in_one_sentence():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(FloatingPointError, match="too fast for a control period of 0"):
            LQG(rig=Rig(J_1=1e-9))
