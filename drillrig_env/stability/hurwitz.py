"""Local stability of steady rotation by the Hurwitz criterion, equations (4-21) to (4-25).

Friction enters the Jacobian (4-19) in one entry, J_33, through its slope Delta T_r1. The
characteristic polynomial det(lambda I - J*) is therefore affine in the slope: with b the 6 x 6
Jacobian that is left without row and column 3,

    det(lambda I - J*(slope)) = det(lambda I - J*(0)) + slope / J_1 det(lambda I - b).

Each Hurwitz minor Delta_i is a polynomial in the slope of degree i at most. Steady rotation is
stable for slopes above the largest of their roots, Delta T_r,min (4-24): friction may fall with
speed no faster than that.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import Chebyshev

from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.model import jacobian
from drillrig_env.rig import Rig, RigLike

_SLOPE_SCALE = 0.1  # N m s/rad; slopes of order 0.01 to 0.1 are where minors change sign


def characteristic_polynomial(rig: Rig, slope: float) -> FloatArray:
    """Coefficients 1, a_1, ..., a_7 of (4-22) for a friction slope Delta T_r1 (N m s/rad); shape (8,)."""
    free = jacobian(rig)
    without_bit = np.delete(np.delete(free, 2, axis=0), 2, axis=1)
    coefficients = np.poly(free)
    coefficients[1:] += slope / rig.J_1 * np.poly(without_bit)
    return np.asarray(coefficients)


def hurwitz_matrix(coefficients: FloatArray) -> FloatArray:
    """The matrix H of (4-23) from 1, a_1, ..., a_n; shape (n, n). Its entry (i, j) is a_(2j - i), from 1."""
    order = len(coefficients) - 1
    i, j = np.indices((order, order)) + 1
    index = 2 * j - i
    inside = (index >= 0) & (index <= order)
    return np.where(inside, np.asarray(coefficients)[np.clip(index, 0, order)], 0.0)


def hurwitz_minors(rig: Rig, slope: float) -> FloatArray:
    """The leading principal minors Delta_1 to Delta_7 of (4-23) at a friction slope; shape (7,)."""
    matrix = hurwitz_matrix(characteristic_polynomial(rig, slope))
    return np.array([np.linalg.det(matrix[:i, :i]) for i in range(1, len(matrix) + 1)])


def minor_polynomials(rig: Rig) -> list[Chebyshev]:
    """Delta_1 to Delta_7 as polynomials in the friction slope (N m s/rad), as NumPy objects.

    Delta_i has degree i at most, so its interpolant at i + 1 points is the polynomial itself. Each
    object evaluates, differentiates and has `roots()`.
    """
    minors = []
    for i in range(7):

        def minor(slopes: FloatArray, i: int = i) -> FloatArray:
            return np.array([hurwitz_minors(rig, slope)[i] for slope in slopes])

        polynomial = Chebyshev.interpolate(minor, i + 1, (-_SLOPE_SCALE, _SLOPE_SCALE))
        # The true degree may be lower (Delta_7 = a_7 Delta_6, and a_7 is constant): drop rounding noise.
        minors.append(polynomial.trim(1e-12 * np.abs(polynomial.coef).max()))
    return minors


@lru_cache(maxsize=256)
def critical_slope(rig: Rig) -> float:
    """Delta T_r,min (4-24): the friction slope (N m s/rad) above which steady rotation is stable.

    The largest real root of any minor. (The chapter says "largest real part of the roots"; a complex
    pair of roots is no change of sign and does not count.) -0.0128 for the chapter's rig (4-25). Raises
    `FloatingPointError` for a rig whose parameters are too far apart for its minors to be computed.
    """
    roots = np.concatenate([minor.roots() for minor in minor_polynomials(rig)])
    real = roots[np.abs(roots.imag) < 1e-9 * (np.abs(roots) + _SLOPE_SCALE)].real
    if not real.size or not np.isfinite(real).all():
        raise FloatingPointError("critical_slope: the minors (4-23) have no finite root; check the rig's parameters")
    return float(real.max())


def critical_speed(rig: RigLike, friction: FrictionLike) -> Quantity:
    """omega_c, the Hopf point (rad/s): steady rotation is unstable below and stable above.

    Where the slope of (4-7) equals Delta T_r,min, in closed form. 0 where friction falls so slowly
    that every speed is stable; infinite where no speed is. One entry a rig for a batch of frictions.
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    slope_at_rest = (
        np.asarray(friction.normal_force) * rig.r_1 * (np.asarray(friction.mu_s) - friction.mu_k) * friction.v_b
    )
    bearable = -critical_slope(rig)
    if bearable <= 0:
        speed = np.full(np.shape(slope_at_rest), np.inf)
    else:
        speed = np.log(np.maximum(slope_at_rest / bearable, 1.0)) / friction.v_b
    return float(speed) if np.ndim(speed) == 0 else np.asarray(speed)


def eigenvalues(rig: RigLike, friction: FrictionLike, speed: float) -> np.ndarray:
    """The 7 eigenvalues (1/s) of the Jacobian (4-19) at steady rotation with `speed` (rad/s), by real part."""
    rig, friction = Rig.of(rig), Friction.of(friction)
    values = np.linalg.eigvals(jacobian(rig, float(friction.slope(rig, speed))))
    return values[np.argsort(-values.real)]


def is_stable(rig: RigLike, friction: FrictionLike, speed: float) -> bool:
    """Whether steady rotation at `speed` (rad/s) is locally stable: all Hurwitz minors are positive."""
    rig, friction = Rig.of(rig), Friction.of(friction)
    return bool(np.all(hurwitz_minors(rig, float(friction.slope(rig, speed))) > 0))
