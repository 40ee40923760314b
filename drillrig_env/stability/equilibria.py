"""Equilibria: the branches e1 and e2 of steady rotation, and the Hopf points H1 and H2 that part them.

Steady rotation (4-16) exists at every speed reference. On the law (4-9) it is stable below omega_s,
inside the stick zone (e1 begins there), unstable from H1 to H2, and stable above H2 (e2).

H2, at omega_c, is a Hopf point proper: a conjugate pair crosses the axis with a finite speed. At H1 the
law has a kink, so the pair does not cross but jumps: on the straight part of (4-9) the slope is
N_1 r_1 mu_s / omega_s, some +240 N m s/rad at 10 N, and beyond the kink it is negative. The chapter's
supercritical Hopf point at omega_min belongs to a drive without integrator (4-15); with the
integrator it moves to omega_s.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.model import friction_input, jacobian, steady_state
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stability.hurwitz import critical_slope, critical_speed, eigenvalues, is_stable

EQUILIBRIUM = np.dtype(
    [
        ("speed_reference", "f8"),
        ("branch", "U2"),
        ("stable", "?"),
        ("stable_by_eigenvalues", "?"),
        ("state", "f8", 7),
        ("eigenvalues", "c16", 7),
    ]
)
"""A point of an equilibrium branch; `stable` is Hurwitz's verdict."""


@dataclass(frozen=True, eq=False)
class HopfPoint:
    """Where steady rotation changes its stability.

    `frequency` (rad/s) of the pair that crosses, `crossing_speed` = d Re(lambda) / d omega_ref (1/s per
    rad/s; the transversality condition asks that it is not 0), and the first Lyapunov coefficient: negative
    is supercritical (a stable orbit is born), positive subcritical. NaN where the law's kink leaves
    them undefined.
    """

    label: str
    speed_reference: float
    frequency: float
    crossing_speed: float
    lyapunov_coefficient: float

    @property
    def criticality(self) -> str:
        """Either "supercritical" or "subcritical"; "kink" where the law has no derivative."""
        if np.isnan(self.lyapunov_coefficient):
            return "kink"
        return "subcritical" if self.lyapunov_coefficient > 0 else "supercritical"


def equilibria(rig: RigLike, friction: FrictionLike, speeds: FloatArray) -> npt.NDArray[np.void]:
    """Steady rotation at each speed reference (rad/s, > 0), as records of EQUILIBRIUM.

    e1 lies below the critical speed and e2 above it.
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    points = np.zeros(len(speeds), dtype=EQUILIBRIUM)
    border = float(critical_speed(rig, friction))
    for point, speed in zip(points, speeds, strict=True):
        values = eigenvalues(rig, friction, float(speed))
        point["speed_reference"] = speed
        point["branch"] = "e1" if speed < border else "e2"
        point["stable"] = is_stable(rig, friction, float(speed))
        point["stable_by_eigenvalues"] = values.real.max() < 0
        point["state"] = steady_state(rig, friction, float(speed)).reshape(7)
        point["eigenvalues"] = values
    return points


def hopf_points(rig: RigLike, friction: FrictionLike) -> list[HopfPoint]:
    """H1 and H2 of one friction; empty where every speed is stable."""
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    border = float(critical_speed(rig, friction))
    if not rig.omega_s < border < np.inf:
        return []
    kink = HopfPoint("H1", rig.omega_s, np.nan, np.nan, np.nan)
    return [kink, _hopf_point(rig, float(friction.v_b), border)]


def _hopf_point(rig: Rig, v_b: float, speed: float) -> HopfPoint:
    """H2 by the projection method: Kuznetsov, Elements of Applied Bifurcation Theory, (5.62).

    The only nonlinearity is T_r1(x_3) with the derivatives -G, v_b G and -v_b^2 G, G = |Delta T_r,min|. The
    middle term of (5.62) vanishes: it holds the mean bit speed, A^-1 b at x_3, on which the drive's integrator insists.
    """
    gain = -critical_slope(rig)
    A, b = jacobian(rig, -gain), friction_input(rig)
    values, modes = np.linalg.eig(A)
    index = int(np.argmin(np.where(values.imag > 0, np.abs(values.real), np.inf)))
    frequency = float(values[index].imag)
    q = modes[:, index]
    left_values, left_modes = np.linalg.eig(A.T)
    p = left_modes[:, int(np.argmin(np.abs(left_values - np.conj(values[index]))))]
    p = p / np.conj(np.vdot(p, q))  # <p, q> = 1

    second, third = v_b * gain, -(v_b**2) * gain
    double = np.linalg.solve(2j * frequency * np.eye(7) - A, b * second * q[2] ** 2)
    cubic = third * q[2] * abs(q[2]) ** 2 + second * np.conj(q[2]) * double[2]
    coefficient = float((np.vdot(p, b) * cubic).real / (2 * frequency))
    crossing = float((np.vdot(p, b) * q[2]).real * v_b * gain)  # d slope / d omega_ref = v_b G
    return HopfPoint("H2", speed, frequency, crossing, coefficient)
