"""What the equations promise: equilibria, periodic orbits, and the speeds at which behaviour changes.

Functions take the rig and the friction as `Rig.of` and `Friction.of` do: a record, a dictionary of changes, a file.

>>> from drillrig_env import Friction, Rig, stability
>>> rig, friction = Rig(), Friction(normal_force=10.0)
>>> round(float(stability.critical_speed(rig, friction)), 3)  # rad/s
1.995
>>> round(float(stability.fold_speed(rig, friction)), 3)
2.901
>>> orbit = stability.stick_slip_orbit(rig, friction, speed_reference=2.0)
>>> round(orbit.period, 2), round(orbit.stuck, 2)  # s, and the share of it at which the bit stands
(2.35, 0.14)
>>> [point.label for point in stability.hopf_points(rig, friction)]
['H1', 'H2']
>>> stability.end_of_stick_slip(rig, friction).kind
'grazing'
"""

from drillrig_env.stability.bifurcation import (
    Branch,
    Diagram,
    bifurcation_diagram,
    force_diagram,
    hopf_and_fold_curves,
)
from drillrig_env.stability.end_of_stick_slip import EndOfStickSlip, end_of_stick_slip
from drillrig_env.stability.equilibria import HopfPoint, equilibria, hopf_points
from drillrig_env.stability.fold import basin_depth, fold_speed
from drillrig_env.stability.hurwitz import (
    characteristic_polynomial,
    eigenvalues,
    hurwitz_matrix,
    hurwitz_minors,
    minor_polynomials,
)
from drillrig_env.stability.limit_cycle import NoOrbitError, slipping_orbit, stick_slip_orbit
from drillrig_env.stability.orbit import PeriodicOrbit
from drillrig_env.stability.stable_sets import critical_slope, critical_speed, is_stable, stable_slopes, stable_speeds

__all__ = [
    "Branch",
    "Diagram",
    "EndOfStickSlip",
    "HopfPoint",
    "NoOrbitError",
    "PeriodicOrbit",
    "basin_depth",
    "bifurcation_diagram",
    "characteristic_polynomial",
    "critical_slope",
    "critical_speed",
    "eigenvalues",
    "end_of_stick_slip",
    "equilibria",
    "fold_speed",
    "force_diagram",
    "hopf_and_fold_curves",
    "hopf_points",
    "hurwitz_matrix",
    "hurwitz_minors",
    "is_stable",
    "minor_polynomials",
    "slipping_orbit",
    "stable_slopes",
    "stable_speeds",
    "stick_slip_orbit",
]
