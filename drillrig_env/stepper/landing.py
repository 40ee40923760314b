"""The state at any time within a solved step, where T_r1 is a cubic of time: exact to rounding.

It is a Taylor series of y' = M y + b T_r1 where no mode is too fast for one. Where one is, the tables of the rungs
below lead there, by halves, quarters and so on of the step, until what is left is short enough for the series.
"""

from __future__ import annotations

from drillrig_env.arrays import FloatArray, Record
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.jit.simd import row, store
from drillrig_env.stepper.collocation import take_step
from drillrig_env.stepper.exponentials import NODES, POWERS_FROM_NODES, RADAU_NODES
from drillrig_env.stepper.ladder import RUNGS, STATE, length_of, table_of

_TAYLOR_LIMIT, _TAYLOR_TOLERANCE = 40, 1e-13
"""Most terms of a Taylor series, and the size of the last one in any state, in its unit."""


@compiled
def land(y: FloatArray, ladder: Record, rung: int, work: Record, share: float) -> bool:
    """Move `y` on within a solved step of `rung`, by a `share` of it; False where no series ends."""
    if rung >= ladder.series_from:
        return _follow_series(y, ladder, rung, work, share)
    cubic = work.cubic
    for i in range(NODES):
        cubic[i] = 0.0
        for j in range(NODES):
            cubic[i] += POWERS_FROM_NODES[i, j] * work.torque[j]
    done, part = 0.0, 1.0
    for below in range(rung, RUNGS):
        left = share - done
        if below >= ladder.series_from:
            _put_torque(work, done, part)
            return _follow_series(y, ladder, below, work, left / part)
        if left >= part:
            _put_torque(work, done, part)
            take_step(y, table_of(ladder, below), work)
            done += part
        part *= 0.5
    return False


@inlined
def _put_torque(work: Record, begin: float, length: float) -> None:
    """T_r1 at the nodes of a part of the step, from the cubic over the whole."""
    cubic = work.cubic
    for j in range(NODES):
        s = begin + RADAU_NODES[j] * length
        work.torque[j] = cubic[0] + s * (cubic[1] + s * (cubic[2] + s * cubic[3]))


@compiled
def _follow_series(y: FloatArray, ladder: Record, rung: int, work: Record, share: float) -> bool:
    """The Taylor series over a `share` of the step of `rung`; False where it does not end."""
    powers, term, M = work.powers, work.term, ladder.rate_from_state
    length = length_of(rung)
    for i in range(NODES):
        powers[i] = 0.0
        for j in range(NODES):
            powers[i] += POWERS_FROM_NODES[i, j] * work.torque[j]
    for i in range(STATE):
        term[i] = y[i]
    scale = 1.0
    for order in range(1, _TAYLOR_LIMIT):
        torque = scale * powers[order - 1] if order <= NODES else 0.0
        scale *= share
        rate = torque * row(ladder.rate_from_torque, 0, STATE) + term[0] * row(M, 0, STATE)
        rate = rate + term[1] * row(M, 1, STATE) + term[2] * row(M, 2, STATE) + term[3] * row(M, 3, STATE)
        rate = rate + term[4] * row(M, 4, STATE) + term[5] * row(M, 5, STATE) + term[6] * row(M, 6, STATE)
        store(term, 0, share / order * length * rate)
        store(y, 0, row(y, 0, STATE) + row(term, 0, STATE))
        small = True
        for i in range(7):
            small &= abs(term[i]) < _TAYLOR_TOLERANCE * ladder.unit[i]
        if small and order >= NODES:
            return True
    return False
