"""Steps within which the mode of a rig changes: find where, land there, and go on with the tables of the other mode.

The state at any time within a solved step is known exactly (`drillrig_env.stepper.landing`), so that a step ends just
where a quantity that its mode goes by meets an edge, and the rest of it is a step of the mode beyond, of the same
length, followed so far. Between its values at both ends of a step the quantity may also dip below an edge and come
back: where its rates at the ends allow for that, it is looked at time and again in between.
"""

from __future__ import annotations

from math import inf, nan

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.stepper.caution import caution_for
from drillrig_env.stepper.collocation import evaluate, solve_nodes
from drillrig_env.stepper.exponentials import NODES
from drillrig_env.stepper.kinks import step_through_kinks
from drillrig_env.stepper.ladder import QUANTITIES, RUNGS, STATE, length_of, table_of
from drillrig_env.stepper.landing import land
from drillrig_env.stepper.turning import begin_turning

_MOST_PIECES = 6
"""Most modes within one step; with more, shorter steps are taken."""

_OF_BEND = 0.25
"""How far a quantity may go beyond its values at both ends of a step, as a share of what its rates are off a line's.

For a parabola it is half as much, and far less for what dies early in the step.
"""

_PARTS = 4
"""Parts of each half, quarter, eighth and so on of a step that are looked at one by one."""

_ROOT_LIMIT, _ROOT_TOLERANCE = 80, 1e-13
"""Most steps in search of a moment, and what is left then of where it may lie, as a share of the step."""


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
        kept = _kept(y, quantity, ladders[mode], work)  # which is the same in every mode
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
    if not ladders[mode].has_modes or _stays(work.before, y, ladders[mode], work, length_of(rung)):
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


@compiled
def way_out(
    y: FloatArray, mode: int, ladders: Records, contact: Record, rung: int, work: Record, upto: float
) -> tuple[float, int]:
    """How far a solved step goes in its mode, as a share of it, and the mode beyond; `upto` and `mode` if it stays.

    The share is 0, and the mode the same, where that is not known. `work.end` is left as the state at `upto`, in
    whatever mode.
    """
    ladder, end = ladders[mode], work.end
    if upto == 1.0:
        table = table_of(ladder, rung)
        evaluate(y, work, table.state_from_state, table.state_from_torque, (0, 1), 0.0, end, 0, STATE)
    else:
        if not _look(y, end, ladder, rung, work, upto):
            return 0.0, mode
    if _stays(y, end, ladder, work, upto * length_of(rung)):
        return upto, mode
    first, beyond = upto, mode
    for quantity in range(QUANTITIES):
        below = _leaves(y, quantity, 1.0, ladder, rung, work, upto)
        above = _leaves(y, quantity, -1.0, ladder, rung, work, upto)
        if not (below >= 0.0 and above >= 0.0):
            return 0.0, mode
        if below < first:
            first, beyond = below, ladder.below[quantity]
        if above < first:
            first, beyond = above, ladder.above[quantity]
    return first, beyond


@inlined
def _stays(begin: FloatArray, end: FloatArray, ladder: Record, work: Record, periods: float) -> bool:
    """Whether a mode clearly holds from one state to another, some `periods` later."""
    inside = True
    for quantity in range(QUANTITIES):
        low, high = ladder.low[quantity], ladder.high[quantity]
        if low > -inf or high < inf:
            first, last = _kept(begin, quantity, ladder, work), _kept(end, quantity, ladder, work)
            rate, later = periods * _rate(begin, quantity, ladder), periods * _rate(end, quantity, ladder)
            bend = _OF_BEND * (abs(rate - (last - first)) + abs(later - (last - first)))
            within = low < min(first, last) - bend and max(first, last) + bend < high
            inside &= within or not abs(last) < inf  # it has overflowed
    return inside


@compiled
def _leaves(y: FloatArray, quantity: int, side: float, ladder: Record, rung: int, work: Record, upto: float) -> float:
    """The share of a solved step at which a quantity leaves its mode, below (`side` 1) or above (-1), or else `upto`.

    It is counted from the edge, inwards. The share is nan where it is not known. What is fast dies early in a step: the
    quantity is looked at in parts of each half, quarter, eighth and so on from its start.
    """
    edge, trial = (ladder.low[quantity] if side > 0.0 else ladder.high[quantity]), work.trial
    if abs(edge) == inf:
        return upto
    begin, first = 0.0, side * (_kept(y, quantity, ladder, work) - edge)
    rate = side * _rate(y, quantity, ladder)
    halvings = max(ladder.series_from - rung, 0) + 1
    for part in range(_PARTS * (halvings + 1)):
        octave = part // _PARTS
        length = length_of(halvings - max(octave - 1, 0))
        end = upto * length * ((part % _PARTS + 1.0) / _PARTS + (1.0 if octave > 0 else 0.0))
        if not _look(y, trial, ladder, rung, work, end):
            return nan
        last, later = side * (_kept(trial, quantity, ladder, work) - edge), side * _rate(trial, quantity, ladder)
        found = _leaves_within(y, begin, end, first, last, rate, later, quantity, side, ladder, rung, work)
        if not found >= end:
            return found
        begin, first, rate = end, last, later
    return upto


@compiled
def _leaves_within(
    y: FloatArray,
    begin: float,
    end: float,
    first: float,
    last: float,
    rate: float,
    later: float,
    quantity: int,
    side: float,
    ladder: Record,
    rung: int,
    work: Record,
) -> float:
    """The same for a part of the step, in which the quantity turns once at most; `end` where it does not leave."""
    edge = ladder.low[quantity] if side > 0.0 else ladder.high[quantity]
    length = (end - begin) * length_of(rung)
    inner, at_inner, outer, at_outer = begin, first, end, last
    if last >= 0.0:  # it may have dipped below, as far as where the tangents from both ends meet
        if not rate < 0.0 < later or first + rate * (last - length * later - first) / (rate - later) >= 0.0:
            return end
    elif first > 0.0:
        return _moment(y, begin, end, first, last, False, quantity, side, ladder, rung, work)
    elif rate <= 0.0:
        return begin
    elif later >= 0.0:
        return nan
    turn = _moment(y, begin, end, rate, later, True, quantity, side, ladder, rung, work)
    if not turn >= 0.0:
        return nan
    there = side * (_kept(work.trial, quantity, ladder, work) - edge)
    if last >= 0.0:
        if there >= 0.0:
            return end
        outer, at_outer = turn, there
    else:
        inner, at_inner = turn, there
    if at_inner <= 0.0:
        return begin
    return _moment(y, inner, outer, at_inner, at_outer, False, quantity, side, ladder, rung, work)


@compiled
def _moment(
    y: FloatArray,
    low: float,
    high: float,
    at_low: float,
    at_high: float,
    of_rate: bool,
    quantity: int,
    side: float,
    ladder: Record,
    rung: int,
    work: Record,
) -> float:
    """When a quantity meets its edge, or its rate 0, between two shares of a step at which signs differ.

    By the Illinois method, and by halves in between. `work.trial` is left as the state there; the share is nan where
    it cannot be had.
    """
    edge, trial, last, kept = (ladder.low[quantity] if side > 0.0 else ladder.high[quantity]), work.trial, low, 0
    for k in range(_ROOT_LIMIT):
        share = (low * at_high - high * at_low) / (at_high - at_low) if k % 4 != 3 else 0.5 * (low + high)
        if not _look(y, trial, ladder, rung, work, share):
            return nan
        value = side * (_rate(trial, quantity, ladder) if of_rate else _kept(trial, quantity, ladder, work) - edge)
        if value == 0.0 or high - low <= _ROOT_TOLERANCE or abs(share - last) <= _ROOT_TOLERANCE:
            return share
        last = share
        if (value > 0.0) == (at_low > 0.0):
            low, at_low = share, value
            at_high = 0.5 * at_high if kept == 1 else at_high
            kept = 1
        else:
            high, at_high = share, value
            at_low = 0.5 * at_low if kept == -1 else at_low
            kept = -1
    return nan


@compiled
def _look(y: FloatArray, there: FloatArray, ladder: Record, rung: int, work: Record, share: float) -> bool:
    """Put the state at a `share` of a solved step `there`, and leave `y` and the solution as they are."""
    torque = work.torque_kept
    for j in range(NODES):
        torque[j] = work.torque[j]
    for i in range(STATE):
        there[i] = y[i]
    landed: bool = land(there, ladder, rung, work, share)
    for j in range(NODES):
        work.torque[j] = torque[j]
    return landed


@inlined
def _kept(y: FloatArray, quantity: int, ladder: Record, work: Record) -> float:
    """A quantity that a mode goes by, at a state less its equilibrium."""
    row = ladder.kept[quantity]
    value: float = (row[0] * y[0] + row[1] * y[1]) + (row[2] * y[2] + row[3] * y[3]) + (row[4] * y[4] + row[5] * y[5])
    value += row[6] * y[6]
    value += ladder.kept_at_rest[quantity] + ladder.kept_per_speed[quantity] * work.speed_reference
    return value


@inlined
def _rate(y: FloatArray, quantity: int, ladder: Record) -> float:
    """Its change over a period."""
    row = ladder.kept_rate[quantity]
    value: float = (row[0] * y[0] + row[1] * y[1]) + (row[2] * y[2] + row[3] * y[3]) + (row[4] * y[4] + row[5] * y[5])
    value += row[6] * y[6]
    return value
