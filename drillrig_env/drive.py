"""The drive's speed loop: its gains, and how much of the motor's back-EMF it makes up for.

The voltage of the armature is

    u = k_p (omega_ref - x_5) + k_i x_7 + back_emf_share eta K_E x_5 + voltage_offset.

A drive that makes up for the back-EMF leaves the motor as if it had none, and so without the stiffness that comes
from it: where it makes up for the share s, the model has (1 - s) K_E in place of K_E.

K_E is what the drive takes it for. In a fleet (`drillrig_env.fleet`) that is the nominal rig's, as the motor's
nameplate has it, and the rig's own is another: where it is smaller, a drive that makes up for all of the back-EMF
drives the motor on.

A drive with a `current_limit` I holds what it asks for, u but for the offset, within eta K_E x_5 - R I and + R I, so
that the current goes to I and no further: under a large torque it stalls. Its integrator then follows what is left of
the voltage, by (limited - asked) / k_p beside the speed error (anti-windup by back-calculation, with the time
constant k_p / k_i), and leaves the limit soon after the error has gone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from math import inf
from typing import Any, TypeAlias

import numpy as np

from drillrig_env.allowed import Allowed, Choice, Made
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, SHARE, check_fields, closest, parameter, refuse
from drillrig_env.rig import Rig


@dataclass(frozen=True)
class Drive:
    """A setting of the drive's speed loop, in place of the rig's own. Raises `ValueError` for one not allowed.

    >>> from drillrig_env import Drive, simulate
    >>> stiff, soft = (simulate(speed_reference=2.0, drive=drive) for drive in (None, Drive(0.041, 0.0073, 1.0)))
    >>> bool(stiff.bit_speed[-300:].min() < 0.1 < soft.bit_speed[-300:].min())  # in stick-slip, and out of it
    True
    """

    k_p: float = parameter(unit="V s/rad", meaning="proportional gain of the speed loop", allowed=NOT_NEGATIVE)
    k_i: float = parameter(unit="V/rad", meaning="integral gain of the speed loop", allowed=POSITIVE)
    back_emf_share: float = parameter(
        0.0, meaning="share of the motor's back-EMF that the drive makes up for", allowed=SHARE
    )
    back_emf: str = parameter(
        "nameplate",
        meaning="whose back-EMF that is on a rig of a fleet: that on the nominal rig's nameplate, or the very motor's",
        allowed=Choice(("nameplate", "motor")),
    )
    voltage_offset: float = parameter(
        0.0, "V", "constant voltage of the armature beside what the speed loop asks for", allowed=Allowed()
    )
    current_limit: float | None = parameter(
        None, "A", "largest armature current that the drive asks for", allowed=POSITIVE, none="no limit"
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if self.current_limit is not None and self.k_p == 0.0:
            raise refuse("Drive", "k_p", self.k_p, "V s/rad", f"{POSITIVE} with a current_limit")

    @classmethod
    def of(cls, drive: DriveLike) -> Drive | None:
        """A drive as functions take it: a `Drive`, a dictionary of its fields, (k_p, k_i), or with the share as third.

        None stands for the rig's own and stays None. Raises `ValueError` for anything else.
        """
        if drive is None or isinstance(drive, cls):
            return drive
        names = [item.name for item in fields(cls)]
        if isinstance(drive, np.ndarray):
            drive = drive.tolist()
        if isinstance(drive, Sequence) and not isinstance(drive, str) and len(drive) in (2, 3):
            drive = dict(zip(names, drive, strict=False))
        if not isinstance(drive, Mapping):
            raise refuse("Drive", "drive", repr(drive), "", f"a Drive, a dictionary of its fields, or {_SEQUENCE}")
        for name in drive:
            if name not in names:
                raise ValueError(f"drive: unknown field {name!r}; {closest(name, names)}")
        for name in names[:2]:
            if name not in drive:
                raise ValueError(f"drive: the field {name} is missing in {dict(drive)}; {_SEQUENCE}")
        return cls(**drive)

    @classmethod
    def of_rig(cls, rig: Rig) -> Drive:
        """The drive that the rig's own parameters describe."""
        return cls(rig.k_p, rig.k_i)

    def remaining_K_E(self, rig: Rig) -> float:
        """Voltage constant K_E (V s/rad) of the motor as this drive leaves it; below 0 where it drives the motor on.

        `rig` has the motor.
        """
        return (1.0 - self.back_emf_share) * rig.K_E

    def compensation(self, rig: Rig) -> float:
        """Voltage that makes up for the back-EMF, for each rad/s of the top speed x_5 (V s/rad).

        `rig` has the motor.
        """
        return rig.eta * (rig.K_E - self.remaining_K_E(rig))

    def on(self, nominal: Rig) -> Drive:
        """The drive as it is on rigs of a fleet with this nominal rig."""
        if self.back_emf_share == 0.0 or self.back_emf == "motor":
            return self
        own = {item.name: getattr(self, item.name) for item in fields(Drive)}
        return _OfNameplate(**own, nameplate=nominal)

    def room(self, rig: Rig) -> float:
        """How far (V) the voltage may be from the back-EMF: R times the largest current; infinite without a limit.

        `rig` has the motor.
        """
        return inf if self.current_limit is None else rig.R * self.current_limit

    def as_dict(self) -> dict[str, Any]:
        """Its fields by name, as `Drive.of` takes them; for files."""
        found = {item.name: getattr(self, item.name) for item in fields(Drive)}
        if self.back_emf == "nameplate":  # which says nothing where there is one rig
            del found["back_emf"]
        if self.voltage_offset == 0.0:
            del found["voltage_offset"]
        if self.current_limit is None:
            del found["current_limit"]
        return found


@dataclass(frozen=True)
class _OfNameplate(Drive):
    """A drive that makes up for a share of the back-EMF of another motor."""

    nameplate: Rig = parameter(Rig(), meaning="the rig that it takes for its own", allowed=Made(Rig.of, "a rig"))

    def remaining_K_E(self, rig: Rig) -> float:
        return rig.K_E - self.back_emf_share * self.nameplate.K_E * (self.nameplate.eta / rig.eta)


@dataclass(frozen=True)
class Limiting:
    """A drive while it limits the current, forwards (`side` 1) or backwards (-1)."""

    drive: Drive
    side: int

    @property
    def current(self) -> float:
        """What the current goes to, without an offset of the voltage, in A."""
        return self.side * (self.drive.current_limit or 0.0)


_SEQUENCE = "(k_p in V s/rad, k_i in V/rad) with or without the share of the back-EMF, 0 to 1"

DriveLike: TypeAlias = Drive | Mapping[str, Any] | Sequence[float] | None
"""What `Drive.of` takes."""
