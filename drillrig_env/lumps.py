"""A string of steel as three lumps: what its lengths and diameters make of inertias, stiffnesses and damping.

A tube of length l has the polar moment I = pi (D^4 - d^4) / 32, the inertia rho I l and the stiffness G I / l. The
drill pipe, which is what winds up, becomes two springs in a row, each twice as stiff as all of it, with half of its
inertia between them and a quarter at either end: total inertia and static stiffness are matched. The collars, 7 times
as stiff, turn as one with the bit. Energy is lost in the steel and the joints in proportion to the rate of twist.

A tube of diameter D that turns amid a round hole of diameter H full of mud of the viscosity mu drags, in laminar flow
(Couette's), with the torque pi mu D^2 H^2 / (H^2 - D^2) for each metre and rad/s. It is lumped as the inertia is.

Which motions are in it: torsion, on bottom, of a nearly vertical string. No axial motion, no bending, no friction along
the wall that sticks, and above its two lowest modes no other.

>>> from drillrig_env.lumps import Mud, Tube, three_lumps
>>> pipe, collars = Tube(length=2000.0, outer=0.127, inner=0.1086), Tube(length=200.0, outer=0.171, inner=0.0714)
>>> steel = {"density": 7850.0, "shear_modulus": 79.3e9, "loss_time": 0.01}
>>> lumps = three_lumps(pipe, collars, top_drive=2000.0, mud=Mud(viscosity=0.02, hole=0.216), **steel)
>>> {name: round(lumps[name], 1) for name in ("J_1", "J_2", "J_3", "k_1", "d_1", "C_1")}
{'J_1': 174.4, 'J_2': 93.3, 'J_3': 2046.6, 'k_1': 942.4, 'd_1': 9.4, 'C_1': 1.8}
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, check_fields, parameter, refuse

STEEL = {"density": 7850.0, "shear_modulus": 79.3e9}
"""Density (kg/m^3) and shear modulus (Pa) of steel."""

LOSS_TIME = 20.0 / 819.0
"""Damping over stiffness of the shafts, s: an assumption, 2 % of the critical damping in the lowest mode of 2.5 km."""


@dataclass(frozen=True)
class Tube:
    """A length of pipe or of collars. Raises `ValueError` for one that is not allowed."""

    length: float = parameter(unit="m", meaning="length", allowed=POSITIVE)
    outer: float = parameter(unit="m", meaning="outer diameter", allowed=POSITIVE)
    inner: float = parameter(0.0, unit="m", meaning="inner diameter", allowed=NOT_NEGATIVE)

    def __post_init__(self) -> None:
        check_fields(self)
        if self.inner >= self.outer:
            raise refuse("Tube", "inner", self.inner, "m", f"< outer = {self.outer}")

    @classmethod
    def of(cls, tube: Any) -> Tube:
        """A tube from (length, outer, inner) in m, or from a dictionary of these. `ValueError` for anything else."""
        if isinstance(tube, cls):
            return tube
        try:
            return cls(**tube) if isinstance(tube, dict) else cls(*tube)
        except TypeError as error:
            raise refuse(
                "Tube", "tube", repr(tube), "", "(length, outer, inner) in m, or a dictionary of them"
            ) from error

    @property
    def polar_moment(self) -> float:
        """Polar moment of area, m^4."""
        return pi / 32.0 * (self.outer**4 - self.inner**4)

    def inertia(self, density: float) -> float:
        """Inertia about its axis, kg m^2; `density` in kg/m^3."""
        return density * self.polar_moment * self.length

    def stiffness(self, shear_modulus: float) -> float:
        """Torsional stiffness from end to end, N m/rad; `shear_modulus` in Pa."""
        return shear_modulus * self.polar_moment / self.length


@dataclass(frozen=True)
class Mud:
    """What a string turns in. Raises `ValueError` for values that are not allowed."""

    viscosity: float = parameter(unit="Pa s", meaning="viscosity, 0.03 for a common mud", allowed=NOT_NEGATIVE)
    hole: float = parameter(unit="m", meaning="diameter of the hole", allowed=POSITIVE)

    def __post_init__(self) -> None:
        check_fields(self)

    @classmethod
    def of(cls, mud: Any) -> Mud | None:
        """Mud from (viscosity in Pa s, hole in m), or from a dictionary of these; None stays None.

        `mud` is any of these.

        `ValueError` for anything else.
        """
        if mud is None or isinstance(mud, cls):
            return mud
        try:
            return cls(**mud) if isinstance(mud, dict) else cls(*mud)
        except TypeError as error:
            raise refuse("Mud", "mud", repr(mud), "", "(viscosity in Pa s, hole in m), or a dictionary") from error

    def drag(self, tube: Tube) -> float:
        """Torque of the mud on a tube for each rad/s at which it turns, N m s/rad. `ValueError` for one too thick."""
        if tube.outer >= self.hole:
            raise refuse("Mud", "hole", self.hole, "m", f"> outer = {tube.outer}")
        outside, inside = self.hole**2, tube.outer**2
        return pi * self.viscosity * tube.length * outside * inside / (outside - inside)


def three_lumps(
    pipe: Tube,
    collars: Tube,
    top_drive: float,
    density: float,
    shear_modulus: float,
    loss_time: float,
    mud: Mud | None = None,
) -> dict[str, float]:
    """Inertias (kg m^2), stiffnesses (N m/rad) and damping (N m s/rad) of a string, by the names of `Rig`.

    `pipe` hangs above `collars`; `density` (kg/m^3) and `shear_modulus` (Pa) are those of their steel.

    `top_drive` is the inertia of what turns at the top (kg m^2), `loss_time` damping over stiffness (s). What `mud`
    takes from the topmost quarter of the pipe is a loss of the motor, C_m, which turns with it at eta = 1.
    """
    inertia, stiffness = pipe.inertia(density), 2.0 * pipe.stiffness(shear_modulus)
    on_pipe, on_collars = (0.0, 0.0) if mud is None else (mud.drag(pipe), mud.drag(collars))
    return {
        "J_1": collars.inertia(density) + inertia / 4.0,
        "J_2": inertia / 2.0,
        "J_3": top_drive + inertia / 4.0,
        "k_1": stiffness,
        "k_2": stiffness,
        "d_1": stiffness * loss_time,
        "d_2": stiffness * loss_time,
        "C_1": on_collars + on_pipe / 4.0,
        "C_2": on_pipe / 2.0,
        "C_m": on_pipe / 4.0,
    }
