"""Section 4.4.2: Hurwitz criterion, critical speeds, Hopf point and torsional vibration map."""

from __future__ import annotations

from dataclasses import replace
from math import log

import numpy as np

from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.stability import (
    critical_slope,
    critical_speed,
    eigenvalues,
    hopf_points,
    is_stable,
    minor_polynomials,
    stick_slip_orbit,
)
from drillrig_env.validation.check import Check, claim, number

PRINTED_CRITICAL_SPEEDS = {10.0: 1.994, 20.0: 2.689}  # rad/s, over N_1 in N
MAP_FORCES = (5.0, 10.0, 20.0, 30.0, 40.0)  # N


def checks() -> list[Check]:
    """All checks of this module."""
    rig = Rig()
    return [*criterion(rig), *critical_speeds(rig), *crossing(rig), *vibration_map(rig)]


def criterion(rig: Rig) -> list[Check]:
    """Delta T_r,min (4-25), what it rests on, and the motor's share in it."""
    roots = np.concatenate([minor.roots() for minor in minor_polynomials(rig)])
    slope = critical_slope(rig)
    forces, speeds = np.arange(2.0, 41.0, 2.0), np.linspace(0.05, 6.0, 60)
    points = [(Friction(force), speed) for force in forces for speed in speeds]
    unlike = sum(is_stable(rig, f, w) != bool(eigenvalues(rig, f, w).real.max() < 0) for f, w in points)
    stiff = critical_slope(replace(rig, k_p=1e4))
    flat = replace(Friction(10.0), mu_s=Friction().mu_k)
    return [
        number(
            "(4-25)",
            "Delta T_r,min",
            -0.0128,
            slope,
            "N m s/rad",
            tolerance=5e-5,
            decimals=6,
            remark="the motor's data were identified so that it does",
        ),
        claim(
            "(4-24)",
            "Delta T_r,min is the largest real part of the roots of the minors",
            f"with complex roots {roots.real.max():.6f}, with real ones only {slope:.6f} N m s/rad",
            bool(np.isclose(roots.real.max(), slope)),
            "only real roots are changes of sign; here it makes no difference",
        ),
        claim(
            "(4-22), (4-23)",
            "stable exactly where all Hurwitz minors are positive",
            f"minors and eigenvalues disagree at {unlike} of {len(points)} points, 2 to 40 N, 0.05 to 6 rad/s",
            unlike == 0,
        ),
        claim(
            "sections 4.4.2, 4.5",
            "the falling friction is crucial: without a slope there is no instability",
            f"critical speed with mu_s = mu_k at 10 N: {critical_speed(rig, flat):g} rad/s",
            critical_speed(rig, flat) == 0.0,
        ),
        claim(
            "sections 4.3, 4.5",
            "the drive influences the string: both must be considered",
            f"Delta T_r,min with a stiff drive (k_p = 1e4 V s/rad): {stiff:.5f} N m s/rad",
            round(stiff, 4) != round(slope, 4),
            f"the identified drive bears {100 * (slope / stiff - 1):.1f} % more slope than a stiff one",
        ),
    ]


def critical_speeds(rig: Rig) -> list[Check]:
    """The two printed critical speeds, and the distance between them."""
    rows = [
        number(
            f"figures 4.8, 4.9, {figure}",
            f"critical speed omega_c at {force:g} N",
            printed,
            float(critical_speed(rig, Friction(force))),
            "rad/s",
            tolerance=0.002,
            decimals=5,
        )
        for (force, printed), figure in zip(PRINTED_CRITICAL_SPEEDS.items(), ("4.12", "4.13"), strict=True)
    ]
    printed = PRINTED_CRITICAL_SPEEDS[20.0] - PRINTED_CRITICAL_SPEEDS[10.0]
    distance = log(2.0) / float(np.max(Friction().v_b))
    rounding = 0.001  # two numbers, each rounded to 0.001
    between = claim(
        "figure 4.8",
        "omega_c(20 N) - omega_c(10 N)",
        f"{distance:.5f} rad/s",
        abs(printed - distance) <= rounding,
        "by (4-7) it is ln(2)/v_b for every rig, so no rig can have both printed speeds to the last digit; "
        "ours are off by about 0.001 each, in opposite directions",
        f"{printed:.3f} rad/s",
    )
    changed = [float(critical_speed(rig, Friction(force))) for force in MAP_FORCES]
    rises = claim(
        "figure 4.13",
        "omega_c changes with N_1",
        ", ".join(f"{speed:.3f}" for speed in changed)
        + " rad/s at "
        + ", ".join(f"{force:g}" for force in MAP_FORCES)
        + " N",
        bool(np.all(np.diff(changed) > 0)),
    )
    return [*rows, between, rises]


def crossing(rig: Rig) -> list[Check]:
    """The Hopf point H2 at 10 N: the pair, its transversality and its criticality."""
    friction = Friction(10.0)
    hopf = {point.label: point for point in hopf_points(rig, friction)}["H2"]
    below, at, above = (
        eigenvalues(rig, friction, hopf.speed_reference + offset)[:2].real.max() for offset in (-0.1, 0.0, 0.1)
    )
    return [
        claim(
            "figure 4.10",
            "a conjugate pair crosses the imaginary axis at omega_c",
            f"real part {below:+.4f}, 0, {above:+.4f} 1/s at omega_c - 0.1, omega_c, omega_c + 0.1 rad/s; "
            f"frequency {hopf.frequency:.4f} rad/s",
            bool(below > 0 > above and abs(at) < 1e-9),
        ),
        claim(
            "section 4.5",
            "transversality: d Re(lambda) / d omega is not 0 at omega_c",
            f"{hopf.crossing_speed:.4f} 1/s per rad/s",
            hopf.crossing_speed != 0.0,
        ),
        claim(
            "figure 4.12",
            "the Hopf point H2 at omega_c is subcritical",
            f"first Lyapunov coefficient {hopf.lyapunov_coefficient:+.5f}",
            hopf.criticality == "subcritical",
            "positive is subcritical; the same for every N_1",
        ),
    ]


def vibration_map(rig: Rig) -> list[Check]:
    """Either side of the curve of figure 4.11(a)."""
    borders = {force: float(critical_speed(rig, Friction(force))) for force in MAP_FORCES}
    forces = ", ".join(f"{force:g}" for force in MAP_FORCES)
    left = [
        not is_stable(rig, Friction(force), 0.9 * border)
        and stick_slip_orbit(rig, Friction(force), 0.9 * border).stable
        for force, border in borders.items()
    ]
    right = [is_stable(rig, Friction(force), 1.1 * border) for force, border in borders.items()]
    sticking = [stick_slip_orbit(rig, Friction(force), 1.1 * border).stable for force, border in borders.items()]
    return [
        claim(
            "figure 4.11(a)",
            "left of the curve the system undergoes torsional vibrations",
            f"at 0.9 omega_c steady rotation is unstable and stick-slip stable at {sum(left)} of {len(left)} forces "
            f"({forces} N)",
            all(left),
        ),
        claim(
            "figure 4.11(a)",
            "right of the curve steady rotation is stable",
            f"at 1.1 omega_c at {sum(right)} of {len(right)} forces",
            all(right),
        ),
        claim(
            "figure 4.11(a)",
            "right of the curve the system presents no vibration",
            f"at 1.1 omega_c stick-slip is stable as well at {sum(sticking)} of {len(sticking)} forces",
            not any(sticking),
            "the curve is the end of unstable rotation, not of stick-slip, which goes on up to the fold; the chapter's "
            "own figures 4.7 (25 N at 3.0 rad/s) and 4.12 show it",
        ),
    ]
