"""The rigs of a batch: their tables side by side, of which the kernels take those of an episode's rig by its index.

The first ones are the scenario's fleet, or the nominal rig alone. After them come guests: rigs that a reset has asked
for by themselves, kept for as long as an episode has them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.allowed import Allowed
from drillrig_env.drive import Drive
from drillrig_env.env.task import Task
from drillrig_env.fleet import Members, of_one, side_by_side, with_gains_of
from drillrig_env.model import estimate_of_torque
from drillrig_env.parameters import refuse
from drillrig_env.rig import Rig
from drillrig_env.stepper.tables import Tables, build_tables, step_tables

PLANT = np.dtype(
    [
        ("r_1", "f8"),
        ("omega_s", "f8"),
        ("back_emf_compensation", "f8"),  # back-EMF that the drive makes up for, V s/rad of the top speed
        ("back_emf", "f8"),  # of the motor, V s/rad of the top speed
        ("voltage_room", "f8"),  # V, beside the back-EMF; infinite where the drive has no limit
        ("voltage_offset", "f8"),  # V
        # Of the drive's estimate of the mean torque into the string over a control step:
        ("torque_gain", "f8"),  # how much of that torque is in it
        ("torque_per_speed", "f8"),  # N m s/rad, of the mean top speed
        ("torque_per_change", "f8"),  # N m s/rad, of the change of the top speed
        ("torque_offset", "f8"),  # N m
    ],
    align=True,
)
"""What a control step needs of a rig beside its tables."""


@dataclass(frozen=True, eq=False)
class RigBank:
    """The rigs of a batch, and what kernels need of them; `nominal` is what drive and sensors take each of them for.

    `tables` are those of the episodes' drive, `start_tables` those of the nominal rig's own, with which episodes begin.
    """

    nominal: Rig
    members: Members
    guests: tuple[Rig, ...]
    plants: np.ndarray
    tables: Tables
    start_tables: Tables

    @classmethod
    def of(cls, task: Task, guests: Sequence[Rig] = ()) -> RigBank:
        """The bank of a task, and some guests. Raises `ValueError` for a rig that cannot be computed."""
        return _bank(task.rig, _members_of(task), task.drive, task.control_period, tuple(guests))

    @property
    def rigs(self) -> tuple[Rig, ...]:
        """The rigs in the order of their indices."""
        return (*self.members.rigs, *self.guests)

    def parameters(self, indices: npt.NDArray[np.intp]) -> Any:
        """The parameters of the rigs at some indices, with the attributes of a `Rig`, as `drillrig_env.model` takes it.

        They are arrays with one entry for each of `indices`, or numbers where there is one rig only.
        """
        return self.rigs[0] if len(self.rigs) == 1 else self._columns[indices]

    def read(self, asked: Any, episodes: int) -> list[int | Rig]:
        """Which rig each of some episodes is to have, as a reset is told: by its index in the fleet, or by itself.

        `asked` is one for all of them or a list with one for each. Raises `ValueError` for what is neither.
        """
        listed = isinstance(asked, Sequence | np.ndarray) and not isinstance(asked, str) and np.ndim(asked) > 0
        if listed and len(asked) != episodes:
            raise refuse("reset options", "number of rigs", len(asked), "", f"one, or {episodes}")
        return [self._read_one(each) for each in (asked if listed else [asked] * episodes)]

    def moved(
        self, task: Task, in_use: npt.NDArray[np.intp], asked: Sequence[int | Rig] = ()
    ) -> tuple[RigBank, npt.NDArray[np.intp]]:
        """The bank of a task with the rigs of this one that are in use, and those that are asked for.

        Returns with it the new index of each rig that was here, 0 where it has gone.
        """
        members, guests = _members_of(task), dict[Rig, int]()
        places = np.zeros(len(self.rigs), dtype=np.intp)
        for k in np.unique(in_use):
            if members is self.members and k < len(members):
                places[k] = k
            else:
                places[k] = len(members) + guests.setdefault(self.rigs[k], len(guests))
        for rig in asked:
            if isinstance(rig, Rig) and rig not in members.rigs:
                guests.setdefault(rig, len(guests))
        bank = self if members is self.members and tuple(guests) == self.guests else RigBank.of(task, tuple(guests))
        return bank, places

    def indices(self, asked: Sequence[int | Rig]) -> npt.NDArray[np.intp]:
        """Where rigs, as `read` gives them, are in this bank."""
        rigs = self.rigs
        return np.array([rigs.index(rig) if isinstance(rig, Rig) else rig for rig in asked], dtype=np.intp)

    def _read_one(self, asked: Any) -> int | Rig:
        if np.ndim(asked) == 0 and isinstance(asked, int | float | np.number):
            fleet = Allowed(0, len(self.members) - 1, whole=True)
            if not fleet.holds(asked):
                raise refuse("reset options", "rig", asked, "", f"{fleet}, or a Rig")
            return int(asked)
        if asked is None:
            raise refuse("reset options", "rig", asked, "", "an index of the fleet, or a Rig")
        return with_gains_of(Rig.of(asked), self.nominal)

    @cached_property
    def _columns(self) -> Any:
        return side_by_side(self.rigs)


def _members_of(task: Task) -> Members:
    fleet = task.scenario.rigs
    return of_one(task.rig) if fleet is None else fleet.members(task.rig)


@lru_cache(maxsize=8)
def _bank(nominal: Rig, members: Members, drive: Drive | None, period: float, guests: tuple[Rig, ...]) -> RigBank:
    rigs = (*members.rigs, *(with_gains_of(rig, nominal) for rig in guests))
    seen = drive if drive is None or rigs == (nominal,) else drive.on(nominal)
    plants = np.array([_plant(rig, nominal, seen, period) for rig in rigs], dtype=PLANT)
    fleet = _bank(nominal, members, drive, period, ()) if guests else None
    start = _tables(rigs, period, None, fleet.start_tables if fleet else None)
    tables = start if seen is None else _tables(rigs, period, seen, fleet.tables if fleet else None)
    return RigBank(nominal, members, rigs[len(members) :], plants, tables, start)


def _tables(rigs: tuple[Rig, ...], period: float, drive: Drive | None, known: Tables | None) -> Tables:
    if len(rigs) == 1:
        return step_tables(rigs[0], period, drive=drive)
    return build_tables(rigs, period, drive=drive, known=known)


def _plant(rig: Rig, nominal: Rig, drive: Drive | None, period: float) -> tuple[float, ...]:
    gain, per_speed, per_rate, offset = estimate_of_torque(rig, nominal)
    seen = drive or Drive.of_rig(rig)
    loop = seen.compensation(rig), rig.eta * rig.K_E, seen.room(rig), seen.voltage_offset
    return rig.r_1, rig.omega_s, *loop, gain, per_speed, per_rate / period, offset
