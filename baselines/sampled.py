"""What linear laws are designed with: a linear model over one control step, and the Riccati equation of that."""

from __future__ import annotations

import warnings

import numpy as np
from scipy.linalg import LinAlgError, LinAlgWarning, expm, solve_discrete_are

from drillrig_env.arrays import FloatArray


def over_a_step(rates: FloatArray, period: float) -> FloatArray:
    """exp(A h) of a linear model x' = A x with the `rates` A (1/s), shape (n, n), over a `period` h (s).

    `FloatingPointError` where the rig is so fast or so slow that it is not finite.
    """
    with np.errstate(all="ignore"):
        found = np.asarray(expm(rates * period))
    if not np.isfinite(found).all():
        raise FloatingPointError(
            f"a law cannot be designed: rates up to {np.abs(rates).max():.3g} 1/s in the rig's linear model are too "
            f"fast for a control period of {period:.3g} s; check the rig's inertias, stiffnesses and dampings"
        )
    return found


def riccati(transition: FloatArray, by_input: FloatArray, cost: FloatArray, effort: FloatArray) -> FloatArray:
    """The solution of the discrete algebraic Riccati equation, shape (n, n).

    `transition` and `cost` have the shape (n, n), `by_input` (n, m) and `effort` (m, m). `FloatingPointError` where
    there is none.
    """
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore", LinAlgWarning)
            return np.asarray(solve_discrete_are(transition, by_input, cost, effort))
    except (LinAlgError, ValueError) as error:
        raise FloatingPointError(
            f"a law cannot be designed: its Riccati equation has no solution for this rig ({error})"
        ) from error
