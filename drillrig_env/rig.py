"""The laboratory rig: every parameter of the model with its unit, its source and its allowed values.

Sources: "table 4.1" and "text" are the chapter's; "derived" follows from numbers that the chapter
prints; "identified" is **our assumption**: the chapter leaves the motor's data to another chapter,
and one bench motor that reproduces all four numbers printed for the whole system stands in for it.
The friction of the brake pin is apart, in `drillrig_env.friction.Friction`, since it changes from
one rig to the next.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, check_fields, describe, parameter
from drillrig_env.toml import read_section, record_of, write_section

_TABLE, _TEXT, _DERIVED, _IDENTIFIED = "table 4.1", "text", "derived", "identified"
_BEYOND = "beyond the chapter"


@dataclass(frozen=True)
class Rig:
    """A drill-string rig: two discs on a thin shaft and a DC motor with a PI speed loop.

    All fields are plain numbers in SI units; `print(Rig().describe())` lists them with unit, meaning
    and source. The default is the chapter's rig. A value that is not allowed raises `ValueError`.
    """

    J_1: float = parameter(0.0288, "kg m^2", "inertia of disc 1, the bit", _TABLE, POSITIVE)
    J_2: float = parameter(0.0149, "kg m^2", "inertia of disc 2, the collars", _TABLE, POSITIVE)
    J_3: float = parameter(0.0237, "kg m^2", "inertia of the motor behind the gear, eta^2 J_m", _TABLE, POSITIVE)
    k_1: float = parameter(1.1175, "N m/rad", "stiffness between disc 1 and disc 2", _TABLE, POSITIVE)
    k_2: float = parameter(0.3659, "N m/rad", "stiffness between disc 2 and motor", _TABLE, POSITIVE)
    d_1: float = parameter(0.0202, "N m s/rad", "damping between disc 1 and disc 2", _TABLE, NOT_NEGATIVE)
    d_2: float = parameter(0.0167, "N m s/rad", "damping between disc 2 and motor", _TABLE, NOT_NEGATIVE)
    omega_s: float = parameter(1e-3, "rad/s", "half width of the stick zone of (4-9)", _TEXT, POSITIVE)
    eta: float = parameter(8.0, "", "gear ratio, motor to shaft", _TEXT, POSITIVE)
    T_r2: float = parameter(0.0, "N m", "constant resisting torque on disc 2", _TEXT, NOT_NEGATIVE)
    r_1: float = parameter(0.0485, "m", "radius at which the brake pin presses on disc 1", _DERIVED, POSITIVE)
    L: float = parameter(8.437e-4, "H", "inductance of the armature", _IDENTIFIED, POSITIVE)
    R: float = parameter(0.33, "ohm", "resistance of the armature", _IDENTIFIED, POSITIVE)
    K_T: float = parameter(0.126, "N m/A", "torque constant of the motor", _IDENTIFIED, POSITIVE)
    K_E: float = parameter(0.06785, "V s/rad", "voltage constant of the motor", _IDENTIFIED, NOT_NEGATIVE)
    C_m: float = parameter(
        1.784e-4, "N m s/rad", "speed regulation (viscous loss) of the motor", _IDENTIFIED, NOT_NEGATIVE
    )
    T_f: float = parameter(0.1196, "N m", "internal friction torque of the motor", _IDENTIFIED, NOT_NEGATIVE)
    k_p: float = parameter(3.0, "V s/rad", "proportional gain of the speed loop", _IDENTIFIED, NOT_NEGATIVE)
    k_i: float = parameter(1.0, "V/rad", "integral gain of the speed loop", _IDENTIFIED, POSITIVE)
    C_1: float = parameter(
        0.0, "N m s/rad", "viscous loss of disc 1 to what is around it", _BEYOND, NOT_NEGATIVE, optional=True
    )
    C_2: float = parameter(
        0.0, "N m s/rad", "viscous loss of disc 2 to what is around it", _BEYOND, NOT_NEGATIVE, optional=True
    )

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def J_m(self) -> float:
        """Inertia of the motor itself, J_3 / eta^2 (kg m^2)."""
        return self.J_3 / self.eta**2

    @property
    def impedance(self) -> float:
        """Impedance of the string, sqrt(k_2 (J_1 + J_2)) (N m s/rad), for torque laws at the top."""
        return sqrt(self.k_2 * (self.J_1 + self.J_2))

    @property
    def string_frequencies(self) -> tuple[float, float]:
        """Undamped torsional frequencies of the string with the top held still (Hz)."""
        stiffness = np.array([[self.k_1, -self.k_1], [-self.k_1, self.k_1 + self.k_2]])
        squares = np.linalg.eigvals(np.diag([1 / self.J_1, 1 / self.J_2]) @ stiffness)
        low, high = np.sort(np.sqrt(squares.real)) / (2 * pi)
        return float(low), float(high)

    def describe(self) -> str:
        """A table of all parameters with value, unit, meaning and source."""
        return describe(self)

    @classmethod
    def of(cls, rig: RigLike) -> Rig:
        """A rig as functions take it: None for the chapter's, a `Rig`, a dictionary of changes to it, or a file.

        >>> Rig.of({"k_p": 1.5}) == Rig(k_p=1.5)
        True

        A file is the path of a TOML file as `from_toml` reads it. Raises `ValueError` for what is none of these, for an
        unknown name (with the closest known one) and for a value that is not allowed.
        """
        return record_of(cls, "rig", rig)

    @classmethod
    def from_toml(cls, path: str | Path) -> Rig:
        """Read a rig from the table `[rig]` of a TOML file; every key must be there, and no other.

        A table that says `base = "chapter"` holds changes to the chapter's rig instead. Raises `ValueError` naming
        file, key, value, unit and allowed range, and `FileNotFoundError` where there is no such file.
        """
        return read_section(path, "rig", cls)

    def to_toml(self, path: str | Path) -> None:
        """Write the rig as a TOML file that `from_toml` reads back unchanged."""
        write_section(self, path, "rig")


RigLike: TypeAlias = Rig | Mapping[str, Any] | str | Path | None
"""What `Rig.of` takes."""
