"""Local stability of steady rotation by the Hurwitz criterion, equations (4-21) to (4-25).

Friction enters the Jacobian (4-19) in one entry, J_33, through its slope Delta T_r1. The
characteristic polynomial det(lambda I - J*) is therefore affine in the slope: with b the 6 x 6
Jacobian that is left without row and column 3,

    det(lambda I - J*(slope)) = det(lambda I - J*(0)) + slope / J_1 det(lambda I - b).

Each Hurwitz minor Delta_i is a polynomial in the slope of degree i at most. On the chapter's rig
steady rotation is stable for slopes above the largest of their roots, Delta T_r,min (4-24): friction
may fall with speed no faster than that. `stable_sets` has the stable slopes of any rig, without the
rounding of minors.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.polynomial import Chebyshev

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.model import jacobian
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stability.impedance import impedance_fraction


def characteristic_polynomial(rig: Rig, slope: float) -> FloatArray:
    """Coefficients 1, a_1, ..., a_7 of (4-22) for a friction slope Delta T_r1 (N m s/rad); shape (8,).

    `rig` is one rig.

    >>> import numpy as np
    >>> from drillrig_env import Rig, model
    >>> roots = np.roots(characteristic_polynomial(Rig(), slope=-0.01))
    >>> bool(np.isclose(roots.real.max(), np.linalg.eigvals(model.jacobian(Rig(), slope=-0.01)).real.max()))
    True
    """
    coefficients = impedance_fraction(rig).characteristic(Fraction(slope))[::-1]
    return np.array([float(value / coefficients[0]) for value in coefficients])


def hurwitz_matrix(coefficients: FloatArray) -> FloatArray:
    """The matrix H of (4-23) from 1, a_1, ..., a_n; shape (n, n). Its entry (i, j) is a_(2j - i), from 1.

    `coefficients` are these, shape (n + 1,).

    >>> from drillrig_env import Rig
    >>> hurwitz_matrix(characteristic_polynomial(Rig(), slope=-0.01)).shape
    (7, 7)
    """
    order = len(coefficients) - 1
    i, j = np.indices((order, order)) + 1
    index = 2 * j - i
    inside = (index >= 0) & (index <= order)
    return np.where(inside, np.asarray(coefficients)[np.clip(index, 0, order)], 0.0)


def hurwitz_minors(rig: Rig, slope: float) -> FloatArray:
    """The leading principal minors Delta_1 to Delta_7 of (4-23) at a friction slope; shape (7,).

    `rig` is one rig; `slope` is in N m s/rad.

    >>> from drillrig_env import Friction, Rig, stability
    >>> bool((stability.hurwitz_minors(Rig(), slope=-0.02) > 0.0).all())  # friction falls too fast
    False
    """
    matrix = hurwitz_matrix(characteristic_polynomial(rig, slope))
    return np.array([np.linalg.det(matrix[:i, :i]) for i in range(1, len(matrix) + 1)])


def minor_polynomials(rig: Rig) -> list[Chebyshev]:
    """Delta_1 to Delta_7 as polynomials in the friction slope (N m s/rad), as NumPy objects.

    `rig` is one rig.

    Delta_i has degree i at most, so its interpolant at i + 1 points is the polynomial itself. Each
    object evaluates, differentiates and has `roots()`.

    >>> import numpy as np
    >>> from drillrig_env import Rig
    >>> bool(np.isclose(minor_polynomials(Rig())[0](-0.01), hurwitz_minors(Rig(), slope=-0.01)[0]))
    True
    """
    minors = []
    for i in range(7):

        def minor(slopes: FloatArray, i: int = i) -> FloatArray:
            return np.array([hurwitz_minors(rig, slope)[i] for slope in slopes])

        polynomial = Chebyshev.interpolate(minor, i + 1, (-rig.impedance, rig.impedance))
        # The true degree may be lower (Delta_7 = a_7 Delta_6, and a_7 is constant): drop rounding noise.
        minors.append(polynomial.trim(1e-12 * np.abs(polynomial.coef).max()))
    return minors


def eigenvalues(rig: RigLike, friction: FrictionLike, speed: float) -> np.ndarray:
    """The 7 eigenvalues (1/s) of the Jacobian (4-19) at steady rotation with `speed` (rad/s), by real part.

    `rig` and `friction` are given as `Rig.of` and `Friction.of` take them.

    >>> from drillrig_env import Friction, Rig, stability
    >>> values = stability.eigenvalues(Rig(), Friction(20.0), 2.0)
    >>> bool(values[0].real > 0.0)  # below the critical speed
    True
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    values = np.linalg.eigvals(jacobian(rig, float(friction.slope(rig, speed))))
    return values[np.argsort(-values.real)]
