"""Section 4.1 and the lines of (4-17) and (4-20): parameters, integrator, friction law, slips of sign."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
from scipy.optimize import brentq

from drillrig_env.friction import Friction
from drillrig_env.model import jacobian, state_equations, steady_state
from drillrig_env.rig import Rig
from drillrig_env.simulation import simulate
from drillrig_env.stability import critical_slope
from drillrig_env.validation.check import Check, claim

TABLE_4_1 = {
    **{"J_1": 0.0288, "J_2": 0.0149, "J_3": 0.0237, "k_1": 1.1175, "k_2": 0.3659, "d_1": 0.0202, "d_2": 0.0167},
    **{"mu_s": 0.5, "mu_k": 0.306, "v_b": 1.0},
}

_DERIVATIVE_STEP = 1e-5


def checks() -> list[Check]:
    """All checks of this module."""
    rig, friction = Rig(), Friction(10.0)
    return [*parameters(rig, friction), *laws(rig, friction), *slips(rig)]


def parameters(rig: Rig, friction: Friction) -> list[Check]:
    """Table 4.1, and the chapter's integrator against the fast stepper."""
    ours = asdict(rig) | asdict(friction)
    equal = sum(ours[name] == value for name, value in TABLE_4_1.items())
    pressed = Friction(20.0)
    fast, vode = (simulate(rig, pressed, duration=5.0, method=method).state for method in ("fast", "vode"))
    bound = 1e-5
    return [
        claim(
            "table 4.1",
            "ten mechanical parameters",
            f"{equal} of {len(TABLE_4_1)} as printed",
            equal == len(TABLE_4_1),
        ),
        claim(
            "section 4.1",
            "integrated with VODE, method bdf",
            f"fast stepper and VODE within {bound:g} in every state over 5 s at 20 N, 2 rad/s",
            bool(np.abs(fast - vode).max() < bound),
        ),
    ]


def laws(rig: Rig, friction: Friction) -> list[Check]:
    """The friction law (4-9), the equilibrium (4-16) and the Jacobian (4-20)."""
    below = float(friction.torque(rig, np.nextafter(rig.omega_s, 0.0)))
    jump = below - float(friction.torque(rig, rig.omega_s))
    full = float(friction.torque_discontinuous(rig, 0.0)) - float(friction.torque_discontinuous(rig, -1e-300))
    speed = 2.0
    state = steady_state(rig, friction, speed)

    def rates(x: np.ndarray) -> np.ndarray:
        return np.array(state_equations(x, speed, float(friction.torque(rig, x[2])), rig))

    steps = _DERIVATIVE_STEP * np.eye(7)
    differences = np.array([(rates(state + step) - rates(state - step)) / (2 * _DERIVATIVE_STEP) for step in steps]).T
    entries = jacobian(rig, float(friction.slope(rig, speed)))
    bound = 1e-6
    return [
        claim(
            "(4-9)",
            "the adopted law avoids the discontinuity of (4-7)",
            f"jump at omega_s at 10 N: {jump:.2e} N m; that of (4-7) at standstill: {full:.3f} N m",
            jump <= 0.0,
            f"the straight line ends at mu_s, the curve begins {100 * jump / below:.3f} % lower; "
            "small, but a jump and not only a kink",
        ),
        claim(
            "(4-12) to (4-16)",
            "steady rotation at omega_ref is an equilibrium",
            f"largest rate of (4-17) there at 10 N, 2 rad/s: below {bound:g}",
            bool(np.abs(rates(state)).max() < bound),
        ),
        claim(
            "(4-20)",
            "entries of the Jacobian (J_52 with the sign below)",
            f"difference from derivatives of (4-17) at 10 N, 2 rad/s: below {bound:g} of the largest entry",
            bool(np.abs(entries - differences).max() < bound * np.abs(entries).max()),
        ),
    ]


def slips(rig: Rig) -> list[Check]:
    """What Delta T_r,min would be with the signs as printed."""
    right = critical_slope(rig)
    rows = [
        ("(4-20)", "J_52", "-k_2/J_3", (4, 1), "a slip: the derivative of (4-5e) is +k_2/J_3"),
        (
            "(4-5d), (4-17)",
            "term of x_5 in the balance of disc 2",
            "-d_2 x_5",
            (3, 4),
            "a slip: (4-3b), and J_45 = +d_2/J_2 in (4-20) itself, give +d_2 x_5; with -d_2 x_5 steady rotation (4-16) "
            "would be no equilibrium",
        ),
    ]
    return [
        claim(
            where,
            f"{what} = {printed}, and Delta T_r,min = -0.0128 N m s/rad",
            f"Delta T_r,min with that sign: {wrong:.5f}; with the other: {right:.5f} N m s/rad",
            round(wrong, 4) == round(right, 4),
            remark,
            printed,
        )
        for where, what, printed, entry, remark in rows
        for wrong in [_critical_slope_with_other_sign(rig, entry)]
    ]


def _critical_slope_with_other_sign(rig: Rig, entry: tuple[int, int]) -> float:
    """Delta T_r,min (N m s/rad) by eigenvalues of a Jacobian with one entry of the other sign."""

    def largest_real_part(slope: float) -> float:
        matrix = jacobian(rig, slope)
        matrix[entry] *= -1.0
        return float(np.linalg.eigvals(matrix).real.max())

    return float(brentq(largest_real_part, -0.05, 0.0))
