"""Where a quantity that a mode goes by meets an edge within a solved step.

Between its values at both ends of a step the quantity may also dip below an edge and come back: where its rates at the
ends allow for that, it is looked at time and again in between.
"""

from __future__ import annotations

from math import inf, nan

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.stepper.collocation import evaluate
from drillrig_env.stepper.exponentials import NODES
from drillrig_env.stepper.ladder import QUANTITIES, STATE, length_of, table_of
from drillrig_env.stepper.landing import land

_OF_BEND = 0.25
"""How far a quantity may go beyond its values at both ends of a step, as a share of what its rates are off a line's.

For a parabola it is half as much, and far less for what dies early in the step.
"""

_PARTS = 4
"""Parts of each half, quarter, eighth and so on of a step that are looked at one by one."""

_ROOT_LIMIT, _ROOT_TOLERANCE = 80, 1e-13
"""Most steps in search of a moment, and what is left then of where it may lie, as a share of the step."""


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
    if stays(y, end, ladder, work, upto * length_of(rung)):
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
def stays(begin: FloatArray, end: FloatArray, ladder: Record, work: Record, periods: float) -> bool:
    """Whether a mode clearly holds from one state to another, some `periods` later."""
    inside = True
    for quantity in range(QUANTITIES):
        low, high = ladder.low[quantity], ladder.high[quantity]
        if low > -inf or high < inf:
            first, last = kept_of(begin, quantity, ladder, work), kept_of(end, quantity, ladder, work)
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
    begin, first = 0.0, side * (kept_of(y, quantity, ladder, work) - edge)
    rate = side * _rate(y, quantity, ladder)
    halvings = max(ladder.series_from - rung, 0) + 1
    for part in range(_PARTS * (halvings + 1)):
        octave = part // _PARTS
        length = length_of(halvings - max(octave - 1, 0))
        end = upto * length * ((part % _PARTS + 1.0) / _PARTS + (1.0 if octave > 0 else 0.0))
        if not _look(y, trial, ladder, rung, work, end):
            return nan
        last, later = side * (kept_of(trial, quantity, ladder, work) - edge), side * _rate(trial, quantity, ladder)
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
    there = side * (kept_of(work.trial, quantity, ladder, work) - edge)
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
        value = side * (_rate(trial, quantity, ladder) if of_rate else kept_of(trial, quantity, ladder, work) - edge)
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
def kept_of(y: FloatArray, quantity: int, ladder: Record, work: Record) -> float:
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
