"""Modes of a rig: linear systems that take turns, each a ladder of its own, with the edges at which it hands over.

With T_r2 disc 2 turns forwards, sticks, or turns backwards: T_r2 is a constant torque against it, or within the stick
zone |x_4| < omega_s a viscous one. A drive with a limit lets the speed loop have its way, or holds the current at its
largest, forwards or backwards. A rig without either has one mode.

A mode counts its states from an equilibrium of its own, and says what it goes by: two quantities that are linear in
the states, x_4 and the voltage that the speed loop asks for beyond the back-EMF, the edges between which the mode
holds, and the mode beyond each. `drillrig_env.stepper.switching` leads a step across an edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.drive import Drive, Limiting
from drillrig_env.model import frictionless_state, with_stuck_collars
from drillrig_env.rig import Rig

_FORWARDS, _STICKS, _BACKWARDS = range(3)
_ASKED, _LARGEST, _SMALLEST = range(3)
"""Modes of disc 2, and of the drive. The first one of both is the one in which callers count the states."""


class Mode(NamedTuple):
    """One mode of a rig: the rig and the drive whose tables it has, and what disc 2 and the drive do in it."""

    rig: Rig
    drive: Drive | Limiting | None
    collars: int
    limit: int


def modes_of(rig: Rig, drive: Drive | None) -> list[Mode]:
    """The modes of a rig on a drive."""
    collars = [rig, with_stuck_collars(rig), rig] if rig.T_r2 > 0.0 else [rig]
    drives: list[Drive | Limiting | None] = [drive]
    if drive is not None and drive.current_limit is not None:
        drives += [Limiting(drive, 1), Limiting(drive, -1)]
    return [Mode(one, loop, k, i) for i, loop in enumerate(drives) for k, one in enumerate(collars)]


def arranged(rigs: Sequence[Rig], drive: Drive | None) -> tuple[list[Mode], list[list[int]]]:
    """The modes of some rigs in the order of their ladders, first the first one of each, and where each rig's are."""
    first, further, places = [], list[Mode](), list[list[int]]()
    for k, rig in enumerate(rigs):
        own, *others = modes_of(rig, drive)
        begin = len(rigs) + len(further)
        places.append([k, *range(begin, begin + len(others))])
        first.append(own)
        further += others
    return [*first, *further], places


def join_modes(
    ladders: np.ndarray, places: Sequence[int], modes: Sequence[Mode], rig: Rig, drive: Drive | None
) -> None:
    """Say of the modes of a rig, whose ladders lie at some `places` among all `modes`, when each holds."""
    at = {(modes[place].collars, modes[place].limit): place for place in places}
    for (collars, limit), place in at.items():
        ladder, mode = ladders[place], modes[place]
        ladder["low"], ladder["high"], ladder["has_modes"] = -np.inf, np.inf, len(places) > 1
        if collars == _BACKWARDS:
            untwisted = frictionless_state(replace(rig, T_r2=0.0), 0.0, mode.drive)
            ladder["at_rest"][:7] = 2.0 * untwisted - ladder["at_rest"][:7]
            ladder["torque_at_rest"] = -rig.T_r2
        if rig.T_r2 > 0.0:
            low, high = ((rig.omega_s, np.inf), (-rig.omega_s, rig.omega_s), (-np.inf, -rig.omega_s))[collars]
            below, above = at[min(collars + 1, _BACKWARDS), limit], at[max(collars - 1, _FORWARDS), limit]
            _go_by(ladder, 0, np.eye(7)[3], 0.0, (low, high), (below, above))
        if drive is not None and drive.current_limit is not None:
            room = drive.room(rig)
            low, high = ((-room, room), (room, np.inf), (-np.inf, -room))[limit]
            below = at[collars, _SMALLEST if limit == _ASKED else _ASKED]
            above = at[collars, _LARGEST if limit == _ASKED else _ASKED]
            row = np.zeros(7)
            row[4], row[6] = -(drive.k_p + rig.eta * drive.remaining_K_E(rig)), drive.k_i
            _go_by(ladder, 1, row, drive.k_p, (low, high), (below, above))


def _go_by(
    ladder: np.void,
    quantity: int,
    row: FloatArray,
    per_reference: float,
    edges: tuple[float, float],
    beyond: tuple[int, int],
) -> None:
    """Let a mode hold while row @ states + per_reference omega_ref lies between two edges."""
    ladder["low"][quantity], ladder["high"][quantity] = edges
    ladder["below"][quantity], ladder["above"][quantity] = beyond
    ladder["kept"][quantity, :7] = row
    ladder["kept_rate"][quantity, :7] = ladder["rate_from_state"][:, :7] @ row
    ladder["kept_at_rest"][quantity] = row @ ladder["at_rest"][:7]
    ladder["kept_per_speed"][quantity] = row @ ladder["per_speed"][:7] + per_reference
