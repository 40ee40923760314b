"""The fast stepper along one rig's inputs: a contact for each of many steps, in one compiled call."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray, Records
from drillrig_env.jit.compiled import compiled
from drillrig_env.rig import Rig
from drillrig_env.stepper.ladder import UNITS, from_equilibrium, to_states
from drillrig_env.stepper.propagator import advance
from drillrig_env.stepper.tables import step_tables
from drillrig_env.stepper.workspace import workspace


def advance_along(
    rig: Rig, contacts: np.ndarray, state: FloatArray, period: float, every: int, tolerance: float
) -> FloatArray:
    """Advance one rig over n intervals, each of `every` periods (s), with the contact of each; its states, (n, 7).

    `contacts` are records of CONTACT, shape (n,), `state` has shape (7,). On a tilted disc the angle of the first
    contact is m theta_1 + phi at the start; those of the others follow.
    """
    tables = step_tables(rig, period, tolerance)
    contacts = contacts.copy()
    contacts["period"] = period
    changed = np.ones(len(contacts), dtype=np.bool_)
    changed[1:] = contacts[1:] != contacts[:-1]
    result = np.empty((len(contacts), 7))
    start = np.array(state, dtype=float)
    _advance(start, contacts, changed, every, tables.ladders, workspace(), result)
    return result


@compiled
def _advance(
    state: FloatArray,
    contacts: Records,
    changed: npt.NDArray[np.bool_],
    every: int,
    ladders: Records,
    works: Records,
    result: FloatArray,
) -> None:
    work, ladder = works[0], ladders[0]
    y, angle = work.y, float(contacts[0].angle)
    for i in range(result.shape[0]):
        contact = contacts[i]
        if changed[i]:
            from_equilibrium(state if i == 0 else result[i - 1], contact, ladder, y)
        for _ in range(every):
            twists = y[0] + y[1] - y[6]
            contact.angle = angle - contact.turns * twists
            advance(y, contact, ladders, 0, work, False, UNITS)
            turned = contact.speed_reference * contact.period + (y[0] + y[1] - y[6] - twists)
            angle += contact.turns * turned
        to_states(y, contact, ladder, result[i])
