"""The laboratory rig: every parameter of the model with its unit, its source and its allowed values.

Sources: "table 4.1" and "text" are the chapter's; "derived" follows from numbers that the chapter
prints; "identified" is **our assumption**: the chapter leaves the motor's data to another chapter,
and one bench motor that reproduces all four numbers printed for the whole system stands in for it.
The friction of the brake pin is apart, in `drillrig_env.friction.Friction`, since it changes from
one rig to the next.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from drillrig_env.lumps import LOSS_TIME, STEEL, Mud, Tube, three_lumps
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, check_fields, checked, closest, describe, parameter
from drillrig_env.toml import read_section, record_of, write_section

_TABLE, _TEXT, _DERIVED, _IDENTIFIED = "table 4.1", "text", "derived", "identified"
_BEYOND = "beyond the chapter"


@dataclass(frozen=True)
class Rig:
    """A drill-string rig: two discs on a thin shaft and a DC motor with a PI speed loop.

    All fields are plain numbers in SI units; `print(Rig().describe())` lists them with unit, meaning
    and source. The default is the chapter's rig. A value that is not allowed raises `ValueError`.

    >>> from drillrig_env import Rig
    >>> Rig(J_1=0.05).J_1, Rig().J_1  # kg m^2
    (0.05, 0.0288)
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
    T_r2: float = parameter(0.0, "N m", "dry friction torque on disc 2", _TEXT, NOT_NEGATIVE)
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
        """A rig as functions take it: None for the chapter's, a `Rig`, a dictionary of changes to it, a name, a file.

        >>> Rig.of({"k_p": 1.5}) == Rig(k_p=1.5)
        True

        A name is one of `preset`; a file is the path of a TOML file as `from_toml` reads it, or of a folder with
        `rig.toml` in it, such as that of a calibration. Raises `ValueError` for what is none of these, for an unknown
        name (with the closest known one) and for a value that is not allowed.
        """
        if isinstance(rig, str) and (rig in RIGS or not (Path(rig).suffix or Path(rig).exists())):
            return cls.preset(rig)
        return record_of(cls, "rig", rig)

    @classmethod
    def from_string(
        cls,
        pipe: Tube | Sequence[float],
        collars: Tube | Sequence[float],
        top_drive: float,
        k_p: float,
        k_i: float,
        *,
        density: float = STEEL["density"],
        shear_modulus: float = STEEL["shear_modulus"],
        loss_time: float = LOSS_TIME,
        mud: Mud | Sequence[float] | None = None,
        omega_s: float = 1e-3,
    ) -> Rig:
        """A field string as a rig of three lumps: see `drillrig_env.lumps` for what is matched and what is left out.

        `pipe` and `collars` are (length, outer, inner) in m, `top_drive` is the inertia of what turns at the top
        (kg m^2). The drive is one of torque: with eta = R = K_T = r_1 = 1 and no back-EMF a volt is a newton metre, so
        that `k_p` (N m s/rad) and `k_i` (N m/rad) act on the speed error and its integral, and N_1 mu is the torque
        at the bit. `density` is in kg/m^3, `shear_modulus` in Pa, `loss_time` damping over stiffness in s, `mud`
        (viscosity in Pa s, diameter of the hole in m; None: none) and `omega_s` the half width of the stick zone in
        rad/s. Raises `ValueError` for a value that is not allowed.

        >>> rig = Rig.from_string((2300.0, 0.127, 0.1086), (200.0, 0.1715, 0.0714), 2900.0, k_p=38e3, k_i=100e3)
        >>> round(rig.J_1), round(rig.J_2), round(rig.J_3), round(rig.k_1)
        (183, 107, 2954, 819)
        """
        numbers = (
            ("top_drive", top_drive, "kg m^2", NOT_NEGATIVE),
            ("density", density, "kg/m^3", POSITIVE),
            ("shear_modulus", shear_modulus, "Pa", POSITIVE),
            ("loss_time", loss_time, "s", NOT_NEGATIVE),
        )
        top_drive, density, shear_modulus, loss_time = (checked("from_string", *each) for each in numbers)
        lumps = three_lumps(Tube.of(pipe), Tube.of(collars), top_drive, density, shear_modulus, loss_time, Mud.of(mud))
        return cls(**{**_TORQUE_DRIVE, **lumps}, k_p=k_p, k_i=k_i, omega_s=omega_s)

    @classmethod
    def preset(cls, name: str) -> Rig:
        """A rig by name: "laboratory", the chapter's, or "field_2500m", a string of 2.5 km.

        `RIGS` says what is behind the names. `ValueError` for an unknown one.
        """
        if name not in RIGS:
            raise ValueError(f"rig {name!r} is not known; {closest(name, RIGS)}")
        return cls(**RIGS[name])

    @classmethod
    def from_toml(cls, path: str | Path) -> Rig:
        """Read a rig from the table `[rig]` of a TOML file; every key must be there, and no other.

        `path` is the file.

        A table that says `base = "chapter"` holds changes to the chapter's rig instead. Raises `ValueError` naming
        file, key, value, unit and allowed range, and `FileNotFoundError` where there is no such file.
        """
        return read_section(path, "rig", cls)

    def to_toml(self, path: str | Path) -> None:
        """Write the rig as a TOML file that `from_toml` reads back unchanged.

        `path` is the file, which is written over.
        """
        write_section(self, path, "rig")


_TORQUE_DRIVE = {"eta": 1.0, "r_1": 1.0, "L": 0.01, "R": 1.0, "K_T": 1.0, "K_E": 0.0, "C_m": 0.0, "T_f": 0.0}
"""A drive whose volts are newton metres at the top, 0.01 s late."""

RIGS: dict[str, dict[str, float]] = {
    "laboratory": {},
    "field_2500m": {
        "J_1": 182.6,  # 200 m of collars, 171.5 by 71.4 mm, and a quarter of the pipe
        "J_2": 107.2,  # half of 2,300 m of drill pipe, 127.0 by 108.6 mm
        "J_3": 2954.0,  # a top drive of 2,900 kg m^2 (assumed), and a quarter of the pipe
        "k_1": 819.0,  # each twice the stiffness of the pipe, steel of 79.3 GPa and 7,850 kg/m^3
        "k_2": 819.0,
        "d_1": 20.0,  # assumed
        "d_2": 20.0,
        "k_p": 38e3,  # a stiff speed loop, N m s/rad and N m/rad (assumed)
        "k_i": 100e3,
        **_TORQUE_DRIVE,
    },
}
"""Rigs by name, as changes to the chapter's: "laboratory" is the chapter's, "field_2500m" a string of 2.5 km."""

RigLike: TypeAlias = Rig | Mapping[str, Any] | str | Path | None
"""What `Rig.of` takes."""
