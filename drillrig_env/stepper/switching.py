"""Steps within which the mode of a rig changes: find where, land there, and go on with the tables of the other mode.

The state at any time within a solved step is known exactly (`drillrig_env.stepper.landing`), so that a step ends just
where a quantity that its mode goes by meets an edge (`drillrig_env.stepper.edges`), and the rest of it is a step of the
mode beyond, of the same length, followed so far.
"""

from __future__ import annotations

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.jit.compiled import compiled
from drillrig_env.stepper.caution import caution_for
from drillrig_env.stepper.collocation import solve_nodes
from drillrig_env.stepper.edges import kept_of, stays, way_out
from drillrig_env.stepper.kinks import step_through_kinks
from drillrig_env.stepper.ladder import QUANTITIES, RUNGS, STATE, length_of
from drillrig_env.stepper.landing import land
from drillrig_env.stepper.turning import begin_turning

_MOST_PIECES = 6
"""Most modes within one step; with more, shorter steps are taken."""


@compiled
def enter(y: FloatArray, old: int, new: int, contact: Record, ladders: Records, work: Record) -> None:
    """Count `y`, and a tilted disc's angle, from the equilibrium of another mode, and be as careful as it asks for.

    The speed reference of the contact becomes the speed at which that equilibrium turns.
    """
    here, there, twists = ladders[old], ladders[new], y[0] + y[1] - y[6]
    for i in range(7):
        at_rest = here.at_rest[i] - there.at_rest[i]
        y[i] += at_rest + (here.per_speed[i] - there.per_speed[i]) * work.speed_reference
    contact.angle += contact.turns * (twists - (y[0] + y[1] - y[6]))
    contact.speed_reference = there.at_rest[2] + there.per_speed[2] * work.speed_reference
    work.caution, work.fast_gain = caution_for(contact, there), 0.0


@compiled
def to_own_mode(y: FloatArray, mode: int, contact: Record, ladders: Records, work: Record) -> int:
    """Count a state, counted in some mode so far, in the one that it belongs to; which that is."""
    new = mode
    for quantity in range(QUANTITIES):
        kept = kept_of(y, quantity, ladders[mode], work)  # which is the same in every mode
        for _ in range(_MOST_PIECES):
            if kept < ladders[new].low[quantity]:
                new = ladders[new].below[quantity]
            elif kept > ladders[new].high[quantity]:
                new = ladders[new].above[quantity]
    if new != mode:
        enter(y, mode, new, contact, ladders, work)
    return new


@compiled
def step_across(
    y: FloatArray,
    zone: int,
    mode: int,
    beyond: int,
    ladders: Records,
    contact: Record,
    rung: int,
    work: Record,
    reach: float,
) -> int:
    """Take a step that was solved up to `reach`, where it meets a kink or, if that is another one, the mode `beyond`.

    The mode at its end, or -1, and `y` as it was, if it cannot. The other arguments are those of `solve_nodes`, which
    has left its solution in `work`, with the ladders of all modes.
    """
    if beyond != mode:
        return _step_through_modes(y, zone, mode, beyond, ladders, contact, rung, work, reach)
    if not step_through_kinks(y, zone, contact, ladders[mode], rung, work, reach):
        return -1
    if not ladders[mode].has_modes or stays(work.before, y, ladders[mode], work, length_of(rung)):
        return mode
    if rung == RUNGS - 1:
        return to_own_mode(y, mode, contact, ladders, work)
    for i in range(STATE):
        y[i] = work.before[i]
    return -1


@compiled
def _step_through_modes(
    y: FloatArray,
    zone: int,
    mode: int,
    beyond: int,
    ladders: Records,
    contact: Record,
    rung: int,
    work: Record,
    share: float,
) -> int:
    """The same for a step that stays in its mode for a `share`."""
    origin, old, left = work.origin, mode, 1.0
    angle, speed_reference = contact.angle, contact.speed_reference
    for i in range(STATE):
        origin[i] = y[i]
    for _ in range(_MOST_PIECES):
        if not land(y, ladders[mode], rung, work, share):
            break
        enter(y, mode, beyond, contact, ladders, work)
        mode, left = beyond, left - share
        if contact.tilt > 0.0:
            work.elapsed += share * work.length
            begin_turning(y, contact, work)
        if solve_nodes(y, zone, contact, ladders[mode], rung, work) < 1.0:
            break
        share, beyond = way_out(y, mode, ladders, contact, rung, work, left)
        if beyond == mode:
            if share != left:
                break
            for i in range(STATE):
                y[i] = work.end[i]
            return mode
    for i in range(STATE):
        y[i] = origin[i]
    contact.angle, contact.speed_reference = angle, speed_reference
    work.caution, work.fast_gain = caution_for(contact, ladders[old]), 0.0
    return -1
