"""Following the stick-slip orbit p1 in the speed reference, by pseudo-arclength, to where it ends as a stable one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from drillrig_env.arrays import FloatArray
from drillrig_env.model import frictionless_state
from drillrig_env.stability.multipliers import OFF_SECTION
from drillrig_env.stability.return_map import Passage, ReturnMap
from drillrig_env.stepper.units import units_of

Kind = Literal["grazing", "fold", "other", "lost"]
"""How a branch ends; "lost" where it does not, but could be followed no further."""

_FIRST_STEP, _LONGEST_STEP = 0.01, 0.1
"""Steps in the speed reference, as shares of it."""

_NEWTON_LIMIT, _EASY = 8, 4
_CLOSED = 1e-8
"""An orbit counts as closed when it returns within this, or this share of its largest state, in their own units."""

_SHORTEST_STEP, _MOST_STEPS = 1e-9, 400

_HARDLY_STUCK = 0.01
"""Share of the period in the stick zone below which a branch that cannot be followed on is taken to end at grazing."""

_LOCATED = 1e-5
"""The share of a step to which an end is located: at a fold the speed is stationary."""

_NEAR_ONE = 1e-2
"""How near to +1 a multiplier is where a branch is found to end, for it to end in a fold."""


@dataclass(frozen=True, eq=False)
class _Point:
    """An orbit as a point of the branch: six states and the speed reference, in their own units, and the direction."""

    place: FloatArray
    direction: FloatArray
    passage: Passage
    rounds: int

    @property
    def largest(self) -> complex:
        """The largest multiplier but for the trivial one."""
        values = self.passage.multipliers
        return complex(np.delete(values, int(np.argmin(np.abs(values - 1.0))))[0])

    @property
    def goes_on(self) -> bool:
        """Whether the branch is still that of stable stick-slip on its way to higher speeds."""
        return self.passage.stuck > 0.0 and self.direction[-1] > 0.0 and abs(self.largest) < 1.0


def end_of_branch(returns: ReturnMap, speed_reference: float, orbit: Passage) -> tuple[float, Kind]:
    """The speed reference (rad/s) at which the branch of a stable stick-slip orbit ends, and how.

    `orbit` is its return to the section at `speed_reference` (rad/s).
    """
    speed_unit = units_of(returns.rig).speed
    up = np.eye(7)[6]
    point = _corrected(returns, _place(returns, orbit.state, speed_reference), up)
    if point is None or not point.goes_on:
        return speed_reference, "other"
    step = _FIRST_STEP
    for _ in range(_MOST_STEPS):
        length = step * point.place[-1] / max(point.direction[-1], 1e-3)
        after = _corrected(returns, point.place + length * point.direction, point.direction)
        if after is None or after.passage.stuck == 0.0:
            step *= 0.5
            if step < _SHORTEST_STEP:
                kind: Kind = "grazing" if after or point.passage.stuck < _HARDLY_STUCK else "lost"
                return float(point.place[-1] * speed_unit), kind
        elif not after.goes_on:
            return _between(returns, point, length, after)
        else:
            point, step = after, min(1.5 * step, _LONGEST_STEP) if after.rounds <= _EASY else step
    return float(point.place[-1] * speed_unit), "lost"


def _between(returns: ReturnMap, point: _Point, length: float, beyond: _Point) -> tuple[float, Kind]:
    """The end between a point of the branch and one beyond it, a `length` further on."""
    last = point

    def upwards(share: float) -> float:
        """Which way the branch goes there; -1 where stable stick-slip does not go on upwards."""
        nonlocal last, beyond
        found = _corrected(returns, point.place + share * length * point.direction, point.direction)
        if found is None:
            return -1.0
        if found.goes_on:
            last = found
        else:
            beyond = found
        return float(found.direction[-1]) if found.goes_on or found.direction[-1] < 0.0 else -1.0

    brentq(upwards, 0.0, 1.0, xtol=_LOCATED)
    kind: Kind = "fold" if abs(beyond.largest - 1.0) < _NEAR_ONE else "other"
    return float(last.place[-1] * units_of(returns.rig).speed), kind


def _place(returns: ReturnMap, state: FloatArray, speed_reference: float) -> FloatArray:
    units = units_of(returns.rig)
    off = (state - frictionless_state(returns.rig, speed_reference)) / units.states
    return np.append(off[OFF_SECTION], speed_reference / units.speed)


def _corrected(returns: ReturnMap, predicted: FloatArray, direction: FloatArray) -> _Point | None:
    """The orbit on the plane through a prediction, across a direction, by Newton's method; None where it finds none."""
    units, place = units_of(returns.rig), predicted.copy()
    for rounds in range(_NEWTON_LIMIT):
        speed_reference = float(place[-1] * units.speed)
        if not speed_reference > 0.0:
            return None
        state = frictionless_state(returns.rig, speed_reference)
        state[OFF_SECTION] += place[:6] * units.states[OFF_SECTION]
        passage = returns(state, speed_reference)
        if passage is None:
            return None
        gap = _place(returns, passage.state, speed_reference)[:6] - place[:6]
        slopes = passage.slopes[OFF_SECTION]
        across = np.column_stack([slopes[:, OFF_SECTION] - np.eye(6), slopes[:, 7]])
        system = np.vstack([across, direction])
        if np.abs(gap).max() < _CLOSED * max(1.0, np.abs(place).max()):
            along = np.linalg.solve(system, np.eye(7)[6])
            return _Point(place, along / np.linalg.norm(along), passage, rounds)
        place = place - np.linalg.solve(system, np.append(gap, direction @ (place - predicted)))
    return None
