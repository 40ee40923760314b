"""The fast stepper along one rig's inputs: a contact for each of many intervals, in one compiled call.

Intervals of any length are whole periods and a rest, which is counted in units of the period, and what is left of that
in units of such a unit: two ladders do for all of them.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.drive import Drive
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.rig import Rig
from drillrig_env.stepper.ladder import UNITS, from_equilibrium, to_states
from drillrig_env.stepper.propagator import advance
from drillrig_env.stepper.tables import TOLERANCE, step_tables
from drillrig_env.stepper.workspace import workspace


def advance_along(
    rig: Rig,
    contacts: np.ndarray,
    which: npt.NDArray[np.intp],
    states: FloatArray,
    lengths: FloatArray,
    period: float,
    tolerance: float = TOLERANCE,
    drive: Drive | None = None,
) -> FloatArray:
    """Advance runs of one rig over n intervals of some `lengths` (s), with the contact of each; shape (runs, n, 7).

    `states` has shape (runs, 7). `contacts` are records of CONTACT, shape (k, m), of which interval i has the one of
    index `which[i]`, and `lengths` has shape (k, n): run r has those of row r modulo k. `period` (s) is what steps are
    taken from. On a tilted disc the angle of the first contact of a run is m theta_1 + phi at its start; those of the
    others follow. `drive` takes the place of the rig's own.
    """
    parts = parts_of(lengths, period)
    coarse, fine = ladders_for(rig, parts, period, tolerance, drive)
    result = np.empty((len(states), len(which), 7))
    starts, contacts = np.array(states, dtype=float), contacts.copy()
    angles = contacts["angle"][:, 0].copy()
    _advance(starts, contacts, angles, which, parts, period, coarse, fine, workspace(), result)
    return result


def ladders_for(
    rig: Rig,
    parts: npt.NDArray[np.int64],
    period: float,
    tolerance: float = TOLERANCE,
    drive: Drive | None = None,
) -> tuple[Records, Records]:
    """The ladders of a period (s) and, where some `parts_of` it need them, of a unit of it."""
    coarse = step_tables(rig, period, tolerance, drive)
    fine = step_tables(rig, period / UNITS, tolerance, drive) if parts[..., 2].any() else coarse
    return coarse.ladders, fine.ladders


def parts_of(lengths: FloatArray, period: float) -> npt.NDArray[np.int64]:
    """How many periods, units and units of a unit there are in each of some lengths, shape (..., 3)."""
    periods, rest = np.divmod(np.rint(lengths / period * UNITS**2), UNITS**2)
    return np.stack([periods, *np.divmod(rest, UNITS)], axis=-1).astype(np.int64)


@compiled
def _advance(
    starts: FloatArray,
    contacts: Records,
    angles: FloatArray,
    which: npt.NDArray[np.intp],
    parts: npt.NDArray[np.int64],
    period: float,
    coarse: Records,
    fine: Records,
    works: Records,
    result: FloatArray,
) -> None:
    work, ladder = works[0], coarse[0]
    y = work.y
    for run in range(result.shape[0]):
        row = run % contacts.shape[0]
        angle = angles[row]
        for i in range(result.shape[1]):
            contact = contacts[row, which[i]]
            if i == 0 or which[i] != which[i - 1]:
                from_equilibrium(starts[run] if i == 0 else result[run, i - 1], contact, ladder, y)
            angle = advance_over(contact, coarse, fine, work, parts[row, i], period, angle)
            to_states(y, contact, ladder, result[run, i])


@inlined
def advance_over(
    contact: Record,
    coarse: Records,
    fine: Records,
    work: Record,
    parts: npt.NDArray[np.int64],
    period: float,
    angle: float,
) -> float:
    """Advance `work.y` over an interval of some `parts_of` a period (s); the `angle` (rad) of a tilted disc after it.

    `coarse` and `fine` are the ladders of the period and of a unit of it.
    """
    contact.period = period
    for _ in range(parts[0]):
        angle = _turn(contact, coarse, work, UNITS, angle)
    if parts[1] > 0:
        angle = _turn(contact, coarse, work, parts[1], angle)
    if parts[2] > 0:
        contact.period = period / UNITS
        angle = _turn(contact, fine, work, parts[2], angle)
    return angle


@inlined
def _turn(contact: Record, ladders: Records, work: Record, stop: int, angle: float) -> float:
    """Advance `work.y` over the first `stop` units of a period; the `angle` (rad) of a tilted disc at their end."""
    y = work.y
    twists = y[0] + y[1] - y[6]
    contact.angle = angle - contact.turns * twists
    advance(y, contact, ladders, 0, work, False, stop)
    turned = contact.speed_reference * (contact.period * (stop / UNITS)) + (y[0] + y[1] - y[6] - twists)
    after: float = angle + contact.turns * turned
    return after
