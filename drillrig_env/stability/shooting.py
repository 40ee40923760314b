"""Stick-slip orbits by shooting: Newton's method on the return to the section, from a guess or a wound-up rig."""

from __future__ import annotations

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.model import wound_up
from drillrig_env.stability.multipliers import OFF_SECTION
from drillrig_env.stability.return_map import Passage, ReturnMap
from drillrig_env.stepper.units import units_of

_SETTLING_RETURNS = (12, 120)  # of a wound-up rig before Newton's method; the second where the first leads nowhere
_SLOWER = tuple(1.0 - share for share in (0.05, 0.03, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0))
_NEWTON_LIMIT = 30
_CLOSED = 1e-7
"""An orbit counts as closed when it returns within this (in the rig's own unit of every state), or within a hundredth
of this share of its largest state."""


def find_stick_slip(returns: ReturnMap, speed_reference: float, guess: FloatArray | None = None) -> Passage | None:
    """The return of the stick-slip orbit p1 to itself at a speed reference (rad/s); None where none is found.

    Looked for from a `guess` (7,) near its section point, from a wound-up rig, and from slower orbits: close to the end
    of the branch what attracts to it is small.
    """
    orbit = None if guess is None else _closed(returns, speed_reference, np.array(guess, dtype=float), 1)
    orbit = orbit or settled_stick_slip(returns, speed_reference)
    slower = None if orbit else settled_stick_slip(returns, _SLOWER[0] * speed_reference)
    for share in _SLOWER[1:] if slower else ():
        slower = slower and _closed(returns, share * speed_reference, slower.state, 1)
    return orbit or slower


def settled_stick_slip(returns: ReturnMap, speed_reference: float) -> Passage | None:
    """The return to itself of the stick-slip orbit that a wound-up rig comes to; None where it comes to none."""
    wound = wound_up(returns.rig, returns.friction, speed_reference).reshape(7)
    for settling in _SETTLING_RETURNS:
        orbit = _closed(returns, speed_reference, wound, settling)
        if orbit is not None:
            return orbit
    return None


def _closed(returns: ReturnMap, speed_reference: float, state: FloatArray, settling: int) -> Passage | None:
    """The orbit p1 from a state (7,), by Newton's method after some returns; None where that leads to none.

    A step that does not bring the return closer is left out, and the rig returns by itself instead: p1 attracts, and
    near the fold it does so from further away than Newton's method finds it.
    """
    for _ in range(settling):
        settled = returns(state, speed_reference, with_derivative=False)
        if settled is None:
            return None
        state = settled.state
    passage, units = returns(state, speed_reference), units_of(returns.rig).states
    for _ in range(_NEWTON_LIMIT):
        if passage is None:
            return None
        gap = ((passage.state - state) / units)[OFF_SECTION]
        if np.abs(gap).max() < _CLOSED * max(1.0, 0.01 * np.abs(state / units).max()):
            return passage
        tried = state.copy()
        slopes = passage.slopes[np.ix_(OFF_SECTION, OFF_SECTION)]
        tried[OFF_SECTION] += units[OFF_SECTION] * np.linalg.solve(np.eye(6) - slopes, gap)
        after = returns(tried, speed_reference)
        if after is None or not np.abs((after.state - tried) / units)[OFF_SECTION].max() < np.abs(gap).max():
            tried = passage.state
            after = returns(tried, speed_reference)
        state, passage = tried, after
    return None
