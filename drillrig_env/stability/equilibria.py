"""Equilibria: the branches e1 and e2 of steady rotation, and the Hopf points H1, H2, ... that part them.

Steady rotation (4-16) exists at every speed reference. On the law (4-9) most rigs are stable below
omega_s, inside the stick zone, unstable from H1 to H2 (e1), and stable above H2 (e2). A drive that shakes by
itself has other borders, or more of them: each is a Hopf point.

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
from drillrig_env.model import steady_state
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stability.hurwitz import eigenvalues
from drillrig_env.stability.impedance import impedance, mode_shape
from drillrig_env.stability.slope_of_law import kinks_of, third_derivative
from drillrig_env.stability.stable_sets import Border, is_stable, stable_set, stable_speeds

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
"""A point of an equilibrium branch, by Hurwitz's criterion and by the eigenvalues; e2 is stable, e1 is not."""


@dataclass(frozen=True, eq=False)
class HopfPoint:
    """Where steady rotation changes its stability.

    `label` is H1, H2, ...; `speed_reference` (rad/s) is where it lies, `lyapunov_coefficient` the first one.

    `frequency` (rad/s) of the pair that crosses, `crossing_speed` = d Re(lambda) / d omega_ref (1/s per
    rad/s; the transversality condition asks that it is not 0), and the first Lyapunov coefficient: negative
    is supercritical (a stable orbit is born), positive subcritical. At the law's kink, where the slope jumps, the
    crossing speed is infinite and the others are NaN.
    """

    label: str
    speed_reference: float
    frequency: float
    crossing_speed: float
    lyapunov_coefficient: float

    @property
    def direction(self) -> str:
        """What steady rotation becomes as the speed rises through this point: "stable" or "unstable"."""
        return "stable" if self.crossing_speed < 0 else "unstable"

    @property
    def criticality(self) -> str:
        """Either "supercritical" or "subcritical"; "kink" where the law has no derivative."""
        if np.isnan(self.lyapunov_coefficient):
            return "kink"
        return "subcritical" if self.lyapunov_coefficient > 0 else "supercritical"


def equilibria(rig: RigLike, friction: FrictionLike, speeds: FloatArray) -> npt.NDArray[np.void]:
    """Steady rotation at each speed reference (rad/s, > 0), as records of EQUILIBRIUM.

    `rig` and `friction`, a single one, are given as `Rig.of` and `Friction.of` take them; `speeds` have the shape (n,).

    e1 is where it is unstable, e2 where it is stable.

    >>> import numpy as np
    >>> from drillrig_env import Friction, Rig, stability
    >>> stability.equilibria(Rig(), Friction(20.0), np.array([2.0, 3.0]))["branch"].tolist()
    ['e1', 'e2']
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    points = np.zeros(len(speeds), dtype=EQUILIBRIUM)
    for point, speed in zip(points, speeds, strict=True):
        values = eigenvalues(rig, friction, float(speed))
        point["speed_reference"] = speed
        point["stable"] = is_stable(rig, friction, float(speed))
        point["branch"] = "e2" if point["stable"] else "e1"
        point["stable_by_eigenvalues"] = values.real.max() < 0
        point["state"] = steady_state(rig, friction, float(speed)).reshape(7)
        point["eigenvalues"] = values
    return points


def hopf_points(rig: RigLike, friction: FrictionLike) -> list[HopfPoint]:
    """Every border between stable and unstable speeds of one friction, rising; empty where there is none.

    `rig` and `friction`, a single one, are given as `Rig.of` and `Friction.of` take them.

    H1 is the kink at omega_s, where it is a border; H2, H3, ... are the borders above it, the kink of a linear fall
    among them.

    >>> from drillrig_env import Friction, Rig, stability
    >>> [(point.label, round(point.speed_reference, 3)) for point in stability.hopf_points(Rig(), Friction(20.0))]
    [('H1', 0.001), ('H2', 2.688)]
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    ends = stable_speeds(rig, friction).ravel()
    borders = {border for interval in stable_set(rig) for border in interval if border.slope < 0.0}
    points: list[HopfPoint] = []
    number = 2
    for speed in ends[(ends > 0.0) & (ends < np.inf)].tolist():
        label = "H1" if speed == rig.omega_s else f"H{number}"
        number += speed != rig.omega_s
        if speed == rig.omega_s or speed in kinks_of(rig, friction):
            sign = 1.0 if speed in ends[1::2] else -1.0
            points.append(HopfPoint(label, speed, np.nan, sign * np.inf, np.nan))
        else:
            slope = float(friction.slope(rig, speed))
            border = min(borders, key=lambda one: abs(one.slope - slope))
            points.append(_hopf_point(rig, friction, speed, border, label))
    return points


def _hopf_point(rig: Rig, friction: Friction, speed: float, border: Border, label: str) -> HopfPoint:
    """A Hopf point by the projection method: Kuznetsov, Elements of Applied Bifurcation Theory, (5.62).

    The only nonlinearity is T_r1(x_3), with the derivatives sigma, -v_b sigma and v_b^2 sigma by (4-7). The middle term
    of (5.62) vanishes: it holds the mean bit speed, on which the drive's integrator insists. With the impedance Z, an
    eigenvalue is a zero of Z(lambda) + sigma, so that d lambda / d sigma = -1 / Z'(lambda), and the pair's product
    <p, b> q_3 is the same number.
    """
    sigma, frequency = border.slope, border.frequency
    Z, derivative = impedance(rig, 1j * frequency * np.array([1.0, 2.0]))
    shift = complex(-1.0 / derivative[0])
    v_b = float(friction.v_b)
    second, third = -v_b * sigma, v_b**2 * sigma
    if friction.law != "exponential":
        second, third = float(friction.curvature(rig, speed)), third_derivative(rig, friction, speed)
    mode = mode_shape(rig, np.array(1j * frequency))
    share = 1.0 / float(np.linalg.norm(mode)) ** 2  # |q_3|^2 of the unit eigenvector
    cubic = third - second**2 / complex(Z[1] + sigma)
    coefficient = share * (shift * cubic).real / (2 * frequency)
    crossing = shift.real * second
    return HopfPoint(label, speed, frequency, float(crossing), float(coefficient))
