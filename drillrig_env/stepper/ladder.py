"""The ladder of a rig: all that the stepper knows of it, in one record that kernels read.

It holds the tables of the rungs, steps that each are half as long as the one before, and beside them once for all rungs
what these share: rates, units, bounds on errors. The rungs below a unit, millionths of a period, are hardly ever taken
and lie apart: `drillrig_env.stepper.shortest` makes them when a rig needs them.
"""

from __future__ import annotations

import numpy as np

from drillrig_env.arrays import FloatArray, Record
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.jit.pointer import answer_of, record_at
from drillrig_env.stepper.exponentials import NODES

UNIT_RUNG = 17
UNITS = 1 << UNIT_RUNG
"""Length of a period in units, the steps of UNIT_RUNG: what parts of a period are counted in."""

DEPTH = 22
"""Rungs below, for what is over within no time: a bit that shoots through the stick zone, a disc without inertia."""

RUNGS = UNIT_RUNG + DEPTH + 1

SAMPLES = 16
"""Samples of bit speed and string torque taken inside a period, at equal distances."""

SAMPLED_RUNGS = 4
"""The longest steps, of the rungs below this one, span several samples and have tables for them."""

STATE = 8
"""The 7 states and a pad, so that a row fills whole vector registers."""

QUANTITIES = 2
"""What a mode goes by: x_4, and the voltage that the speed loop asks for beyond the back-EMF."""

RUNG = np.dtype(
    [
        ("node_from_state", "f8", (7, NODES)),
        ("node_from_torque", "f8", (NODES, NODES)),
        ("between_from_state", "f8", (7, NODES)),
        ("between_from_torque", "f8", (NODES, NODES)),
        ("state_from_state", "f8", (7, STATE)),
        ("state_from_torque", "f8", (NODES, STATE)),
    ],
    align=True,
)
"""Tables of one step length, within which time runs from 0 to 1."""

SAMPLES_OF_RUNGS = sum(SAMPLES >> rung for rung in range(SAMPLED_RUNGS))

SAMPLING = np.dtype(
    [
        ("speed_from_state", "f8", 7 * SAMPLES_OF_RUNGS),
        ("speed_from_torque", "f8", NODES * SAMPLES_OF_RUNGS),
        ("torque_from_state", "f8", 7 * SAMPLES_OF_RUNGS),
        ("torque_from_torque", "f8", NODES * SAMPLES_OF_RUNGS),
        ("pad", "f8", SAMPLES),  # what is read past a row with fewer samples
    ],
    align=True,
)
"""Tables of the samples within a step: bit speed and torque into the string, from the states less the equilibrium.

The longest step has SAMPLES of them, each shorter one half as many, and so long are the rows of its table: `rows_of`.
"""

LADDER = np.dtype(
    [
        ("at_rest", "f8", STATE),  # the frictionless equilibrium at the speed reference 0
        ("per_speed", "f8", STATE),  # what 1 rad/s adds to it
        ("unit", "f8", STATE),  # of each state
        ("torque_row", "f8", STATE),  # what 1 unit of each state adds to the torque into the string
        ("torque_at_rest", "f8"),  # N m, of the equilibrium from which states are counted
        ("torque_per_speed", "f8"),  # what 1 rad/s of the speed reference adds to it, N m s/rad
        ("largest_defect", "f8"),  # N m, of a step that is taken
        ("newton_tolerance", "f8"),  # N m
        ("clearly_beyond", "f8"),  # rad/s, how far beyond a kink an iterate tells that the step crosses it
        ("settled", "f8"),  # rad/s, what may be left of the fast settling where the bit leaves the stick zone
        ("landed", "f8"),  # rad/s, how near to a kink a step that leads there ends
        ("growth", "f8"),  # caution for a friction that falls by 1 N m s/rad: what it makes of errors
        ("first", "i8"),  # the rung of the longest steps
        ("fine_from", "i8"),  # the first rung whose steps lead across kinks, so that their place must be exact
        ("series_from", "i8"),  # the first rung over whose step a Taylor series keeps its digits
        ("watched", "b1"),  # whether nodes alone may not see a mode that is fast and lasts
        ("has_modes", "b1"),  # whether this is a mode of several, which holds while quantities keep between edges
        ("low", "f8", QUANTITIES),  # the edges of each
        ("high", "f8", QUANTITIES),
        ("below", "i8", QUANTITIES),  # where among the ladders the mode beyond each is
        ("above", "i8", QUANTITIES),
        ("kept", "f8", (QUANTITIES, STATE)),  # the quantities, of the states less the equilibrium
        ("kept_rate", "f8", (QUANTITIES, STATE)),  # and their change over a period
        ("kept_at_rest", "f8", QUANTITIES),  # what they are at the equilibrium, as for the states
        ("kept_per_speed", "f8", QUANTITIES),
        ("number", "i8"),  # of the rig, for the one who makes the shortest steps
        ("make_shortest", "i8"),  # the address of a function that makes them, and tells where they are
        ("shortest", "i8"),  # the address of the tables below UNIT_RUNG; 0 where they are not made
        ("rate_from_state", "f8", (7, STATE)),  # a period, as the next one: steps have a power of two of it
        ("rate_from_torque", "f8", STATE),
        ("rungs", RUNG, UNIT_RUNG + 1),
        ("sampling", SAMPLING),
    ],
    align=True,
)
"""One rig."""

_SIZE = RUNG.itemsize


@inlined
def table_of(ladder: Record, rung: int) -> Record:
    """The tables of a rung, a RUNG record."""
    return ladder.rungs[rung] if rung <= UNIT_RUNG else _shortest_table(ladder, rung)


@compiled
def _shortest_table(ladder: Record, rung: int) -> Record:
    address = ladder.shortest
    if address == 0:
        address = answer_of(ladder.make_shortest, ladder.number)
    return record_at(address + (rung - UNIT_RUNG - 1) * _SIZE, ladder.rungs[0])


@inlined
def rows_of(rung: int) -> tuple[int, int]:
    """How many entries of a row lie before those of a rung, and how many are its own, in tables of samples."""
    return 2 * SAMPLES - (2 * SAMPLES >> rung), SAMPLES >> rung


@inlined
def length_of(rung: int) -> float:
    """The length of a rung's step in periods, a power of two."""
    return 1.0 / (1 << rung)


@inlined
def from_equilibrium(states: FloatArray, contact: Record, ladder: Record, y: FloatArray) -> None:
    """The 7 `states` less the frictionless equilibrium of `contact`, which the stepper advances, into `y`."""
    for i in range(7):
        y[i] = states[i] - (ladder.at_rest[i] + ladder.per_speed[i] * contact.speed_reference)


@inlined
def to_states(y: FloatArray, contact: Record, ladder: Record, states: FloatArray) -> None:
    """The way back from `y` to the 7 `states`."""
    for i in range(7):
        states[i] = y[i] + (ladder.at_rest[i] + ladder.per_speed[i] * contact.speed_reference)
