"""The rig as its bit feels it: the mechanical impedance Z(s), torque on disc 1 over the speed of disc 1.

The rig is a chain, and so is Z(s): the motor with its speed loop, a shaft, disc 2, a shaft, disc 1,

    Z_3 = J_3 s + eta^2 C_m + eta K_T (eta K_E + k_p + k_i / s) / (L s + R)
    Z_2 = J_2 s + C_2 + 1 / (1 / (d_2 + k_2 / s) + 1 / Z_3)
    Z   = J_1 s + C_1 + 1 / (1 / (d_1 + k_1 / s) + 1 / Z_2).

Friction of the slope sigma adds sigma to it, so that the eigenvalues of the Jacobian (4-19) are the zeros of
Z(s) + sigma; from friction torque to bit speed the transfer function is -1 / Z(s). The integrator of the speed loop
makes Z(0) infinite: in the mean the bit turns as fast as the reference says, whatever the torque. As a fraction of
polynomials, Z = D / (s E), every coefficient is a sum of products of parameters that are not negative: nothing cancels,
whatever the rig's size.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from drillrig_env.rig import Rig

Complex: TypeAlias = npt.NDArray[np.complex128]
Polynomial: TypeAlias = list[Fraction]
"""Coefficients from the constant to the highest power."""


@dataclass(frozen=True)
class Fractional:
    """Z(s) = D(s) / (s E(s)) of a rig, exact: D of degree 7 and E of degree 5, in s (1/s)."""

    D: Polynomial
    E: Polynomial

    def characteristic(self, slope: Fraction) -> Polynomial:
        """D + slope s E, whose roots are the eigenvalues at a friction slope (N m s/rad)."""
        return _sum(self.D, [slope * value for value in [Fraction(0), *self.E]])


@lru_cache(maxsize=256)
def impedance_fraction(rig: Rig) -> Fractional:
    """Z(s) of a rig as a fraction of polynomials, without any rounding."""
    p = _exact(rig)
    shaft_1, shaft_2 = [p["k_1"], p["d_1"]], [p["k_2"], p["d_2"]]
    armature = [p["R"], p["L"]]
    loss = [p["eta"] ** 2 * p["C_m"], p["J_3"]]
    loop = [p["eta"] * p["K_T"] * p["k_i"], p["eta"] * p["K_T"] * (p["eta"] * p["K_E"] + p["k_p"])]
    motor = _sum(_times_s(_product(loss, armature)), loop)  # Z_3 s (L s + R)
    below_2 = _sum(_product(shaft_2, armature), motor)
    disc_2 = _sum(_times_s(_product([p["C_2"], p["J_2"]], below_2)), _product(shaft_2, motor))  # Z_2 s below_2
    below_1 = _sum(disc_2, _product(shaft_1, below_2))
    disc_1 = _sum(_times_s(_product([p["C_1"], p["J_1"]], below_1)), _product(shaft_1, disc_2))
    return Fractional(disc_1, below_1)


def impedance(rig: Rig, s: Complex) -> tuple[Complex, Complex]:
    """Z(s) (N m s/rad) at complex frequencies (1/s, not 0), and its derivative with respect to s; each of s' shape."""
    p = rig
    armature, loop = p.L * s + p.R, p.eta * p.K_T * (p.eta * p.K_E + p.k_p + p.k_i / s)
    Z = p.J_3 * s + p.eta**2 * p.C_m + loop / armature
    slope = p.J_3 - p.eta * p.K_T * p.k_i / (s**2 * armature) - p.L * loop / armature**2
    for J, C, k, d in ((p.J_2, p.C_2, p.k_2, p.d_2), (p.J_1, p.C_1, p.k_1, p.d_1)):
        shaft = d + k / s
        both = shaft + Z
        slope = J + (shaft / both) ** 2 * slope - (Z / both) ** 2 * k / s**2
        Z = J * s + shaft * Z / both + C
    return Z, slope


def mode_shape(rig: Rig, s: Complex) -> Complex:
    """The states that swing as exp(s t) with x_3 = 1 under a torque on disc 1 alone, shape (..., 7); `s` in 1/s, not 0.

    Where s is an eigenvalue of the Jacobian (4-19) this is its eigenvector. The chain is gone up from the motor, so
    that nothing cancels.
    """
    p = rig
    drive = p.eta * p.K_E + p.k_p + p.k_i / s
    x_5 = np.ones_like(s)
    x_6 = -drive / (p.L * s + p.R)
    torque = p.J_3 * s + p.eta**2 * p.C_m - p.eta * p.K_T * x_6
    x_4 = x_5 + torque / (p.d_2 + p.k_2 / s)
    torque = torque + p.J_2 * s * x_4 + p.C_2 * x_4
    x_3 = x_4 + torque / (p.d_1 + p.k_1 / s)
    states = np.stack([(x_3 - x_4) / s, (x_4 - x_5) / s, x_3, x_4, x_5, x_6, -x_5 / s], axis=-1)
    return np.asarray(states / x_3[..., None])


def _exact(rig: Rig) -> dict[str, Fraction]:
    values: dict[str, Any] = {item.name: getattr(rig, item.name) for item in fields(rig)}
    return {name: Fraction(value) for name, value in values.items()}


def _times_s(polynomial: Polynomial) -> Polynomial:
    return [Fraction(0), *polynomial]


def _sum(a: Polynomial, b: Polynomial) -> Polynomial:
    short, long = sorted((a, b), key=len)
    return [x + y for x, y in zip(short, long, strict=False)] + long[len(short) :]


def _product(a: Polynomial, b: Polynomial) -> Polynomial:
    result = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            result[i + j] += x * y
    return result
