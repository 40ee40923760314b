"""What the equations promise: local stability by Hurwitz, the critical slope and the critical speed."""

from drillrig_env.stability.hurwitz import (
    characteristic_polynomial,
    critical_slope,
    critical_speed,
    eigenvalues,
    hurwitz_matrix,
    hurwitz_minors,
    is_stable,
    minor_polynomials,
)

__all__ = [
    "characteristic_polynomial",
    "critical_slope",
    "critical_speed",
    "eigenvalues",
    "hurwitz_matrix",
    "hurwitz_minors",
    "is_stable",
    "minor_polynomials",
]
