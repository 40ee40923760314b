"""Steps within which the mode of a rig changes: find where, land there, and go on with the tables of the other mode.

The state at any time within a solved step is known exactly (`drillrig_env.stepper.landing`), so that a step ends just
where the quantity that its mode goes by meets an edge, and the rest of it is a step of the mode beyond, of the same
length, followed so far. Between its values at both ends of a step the quantity may also dip below an edge and come
back: where the tangents from both ends meet beyond the edge, the lowest point itself is looked at.
"""

from __future__ import annotations

from math import inf, nan

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.stepper.caution import caution_for
from drillrig_env.stepper.collocation import evaluate, solve_nodes
from drillrig_env.stepper.kinks import step_through_kinks
from drillrig_env.stepper.ladder import RUNGS, STATE, length_of, table_of
from drillrig_env.stepper.landing import land
from drillrig_env.stepper.turning import begin_turning

_SWITCHES = 6
"""Most changes of the mode within one step; with more, shorter steps are taken."""

_ROOT_LIMIT, _ROOT_TOLERANCE = 80, 1e-13
"""Most steps in search of a moment, and what is left then of where it may lie, as a share of the step."""


@compiled
def enter(y: FloatArray, old: int, new: int, contact: Record, ladders: Records, work: Record) -> None:
    """Count `y`, and a tilted disc's angle, from the equilibrium of another mode, and be as careful as it asks for."""
    here, there, twists = ladders[old], ladders[new], y[0] + y[1] - y[6]
    for i in range(7):
        at_rest = here.at_rest[i] - there.at_rest[i]
        y[i] += at_rest + (here.per_speed[i] - there.per_speed[i]) * contact.speed_reference
    contact.angle += contact.turns * (twists - (y[0] + y[1] - y[6]))
    work.caution, work.fast_gain = caution_for(contact, there), 0.0


@compiled
def to_own_mode(y: FloatArray, mode: int, contact: Record, ladders: Records, work: Record) -> int:
    """Count a state, counted in some mode so far, in the one that it belongs to; which that is."""
    new, kept = mode, _kept(y, ladders[mode], contact)  # which is the same in every mode
    for _ in range(_SWITCHES):
        if kept < ladders[new].low:
            new = ladders[new].below
        elif kept > ladders[new].high:
            new = ladders[new].above
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
    if not ladders[mode].has_modes or _stays(work.before, y, ladders[mode], contact, length_of(rung)):
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
    origin, old, angle, left = work.origin, mode, contact.angle, 1.0
    for i in range(STATE):
        origin[i] = y[i]
    for _ in range(_SWITCHES):
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
    contact.angle = angle
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
        for i in range(STATE):
            end[i] = y[i]
        if not land(end, ladder, rung, work, upto):
            return 0.0, mode
    if _stays(y, end, ladder, contact, upto * length_of(rung)):
        return upto, mode
    below = _leaves(y, 1.0, ladder, contact, rung, work, upto)
    above = _leaves(y, -1.0, ladder, contact, rung, work, upto)
    if not (below >= 0.0 and above >= 0.0):
        return 0.0, mode
    first, beyond = upto, mode
    if below < first:
        first, beyond = below, ladder.below
    if above < first:
        first, beyond = above, ladder.above
    return first, beyond


@inlined
def _stays(begin: FloatArray, end: FloatArray, ladder: Record, contact: Record, periods: float) -> bool:
    """Whether a mode clearly holds from one state to another, some `periods` later."""
    first, last = _kept(begin, ladder, contact), _kept(end, ladder, contact)
    inside: bool = min(first, last) > ladder.low and max(first, last) < ladder.high
    if not abs(last) < inf:  # it has overflowed
        return True
    rate, later = periods * _rate(begin, ladder), periods * _rate(end, ladder)
    if inside and rate * later < 0.0:
        meet = first + rate * (last - later - first) / (rate - later)
        inside = ladder.low < meet < ladder.high
    return inside


@compiled
def _leaves(y: FloatArray, side: float, ladder: Record, contact: Record, rung: int, work: Record, upto: float) -> float:
    """The share of a solved step at which it leaves its mode, below (`side` 1) or above (-1), or else `upto`.

    The quantity that it goes by is counted from the edge, inwards. The share is nan where it is not known.
    """
    edge, end, trial = (ladder.low if side > 0.0 else ladder.high), work.end, work.trial
    if abs(edge) == inf:
        return upto
    first, last = side * (_kept(y, ladder, contact) - edge), side * (_kept(end, ladder, contact) - edge)
    rate, later = side * _rate(y, ladder), side * _rate(end, ladder)
    inner, outer = 0.0, upto
    comes_back = last >= 0.0 and rate < 0.0 < later
    if comes_back or (last < 0.0 and first <= 0.0 < rate):  # it turns on the way
        turn = nan
        if rate * later < 0.0:
            turn = _moment(y, 0.0, upto, rate, later, True, side, ladder, contact, rung, work)
        if not turn >= 0.0:
            return nan
        there = side * (_kept(trial, ladder, contact) - edge)
        if comes_back:
            outer, last = turn, there
        else:
            inner, first = turn, there
    if last >= 0.0:
        return upto
    if first <= 0.0:
        return 0.0
    return _moment(y, inner, outer, first, last, False, side, ladder, contact, rung, work)


@compiled
def _moment(
    y: FloatArray,
    low: float,
    high: float,
    at_low: float,
    at_high: float,
    of_rate: bool,
    side: float,
    ladder: Record,
    contact: Record,
    rung: int,
    work: Record,
) -> float:
    """When that quantity meets its edge, or its rate 0, between two shares of a step at which signs differ.

    By the Illinois method, and by halves in between. `work.trial` is left as the state there; the share is nan where
    it cannot be had.
    """
    edge, trial, last, kept = (ladder.low if side > 0.0 else ladder.high), work.trial, low, 0
    for k in range(_ROOT_LIMIT):
        share = (low * at_high - high * at_low) / (at_high - at_low) if k % 4 != 3 else 0.5 * (low + high)
        for i in range(STATE):
            trial[i] = y[i]
        if not land(trial, ladder, rung, work, share):
            return nan
        value = side * (_rate(trial, ladder) if of_rate else _kept(trial, ladder, contact) - edge)
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


@inlined
def _kept(y: FloatArray, ladder: Record, contact: Record) -> float:
    """The quantity that a mode goes by, at a state less its equilibrium."""
    row = ladder.kept
    value: float = (row[0] * y[0] + row[1] * y[1]) + (row[2] * y[2] + row[3] * y[3]) + (row[4] * y[4] + row[5] * y[5])
    value += row[6] * y[6]
    value += ladder.kept_at_rest + ladder.kept_per_speed * contact.speed_reference
    return value


@inlined
def _rate(y: FloatArray, ladder: Record) -> float:
    """Its change over a period."""
    row = ladder.kept_rate
    value: float = (row[0] * y[0] + row[1] * y[1]) + (row[2] * y[2] + row[3] * y[3]) + (row[4] * y[4] + row[5] * y[5])
    value += row[6] * y[6]
    return value
