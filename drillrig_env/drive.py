"""The drive's speed loop: its gains, and how much of the motor's back-EMF it makes up for.

The voltage of the armature is

    u = k_p (omega_ref - x_5) + k_i x_7 + back_emf_share eta K_E x_5.

A drive that makes up for the back-EMF leaves the motor as if it had none, and so without the stiffness that comes
from it: where it makes up for the share s, the model has (1 - s) K_E in place of K_E.

K_E is what the drive takes it for. In a fleet (`drillrig_env.fleet`) that is the nominal rig's, as the motor's
nameplate has it, and the rig's own is another: where it is smaller, a drive that makes up for all of the back-EMF
drives the motor on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeAlias

import numpy as np

from drillrig_env.allowed import Choice, Made
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, SHARE, check_fields, closest, parameter, refuse
from drillrig_env.rig import Rig


@dataclass(frozen=True)
class Drive:
    """A setting of the drive's speed loop, in place of the rig's own. Raises `ValueError` for one not allowed."""

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

    def __post_init__(self) -> None:
        check_fields(self)

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
        """Voltage constant K_E (V s/rad) of the motor as this drive leaves it; below 0 where it drives the motor on."""
        return (1.0 - self.back_emf_share) * rig.K_E

    def compensation(self, rig: Rig) -> float:
        """Voltage that makes up for the back-EMF, for each rad/s of the top speed x_5 (V s/rad)."""
        return rig.eta * (rig.K_E - self.remaining_K_E(rig))

    def on(self, nominal: Rig) -> Drive:
        """The drive as it is on rigs of a fleet with this nominal rig."""
        if self.back_emf_share == 0.0 or self.back_emf == "motor":
            return self
        return _OfNameplate(self.k_p, self.k_i, self.back_emf_share, nameplate=nominal)

    def as_dict(self) -> dict[str, Any]:
        """Its fields by name, as `Drive.of` takes them; for files."""
        found = {item.name: getattr(self, item.name) for item in fields(Drive)}
        if self.back_emf == "nameplate":  # which says nothing where there is one rig
            del found["back_emf"]
        return found


@dataclass(frozen=True)
class _OfNameplate(Drive):
    """A drive that makes up for a share of the back-EMF of another motor."""

    nameplate: Rig = parameter(Rig(), meaning="the rig that it takes for its own", allowed=Made(Rig.of, "a rig"))

    def remaining_K_E(self, rig: Rig) -> float:
        return rig.K_E - self.back_emf_share * self.nameplate.K_E * (self.nameplate.eta / rig.eta)


_SEQUENCE = "(k_p in V s/rad, k_i in V/rad) with or without the share of the back-EMF, 0 to 1"

DriveLike: TypeAlias = Drive | Mapping[str, Any] | Sequence[float] | None
"""What `Drive.of` takes."""
