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

SHORTEST_STEP = 1e-9
"""Share of the speed below which a step leads nowhere."""

_MOST_STEPS = 400

_HARDLY_STUCK = 0.01
"""Share of the period in the stick zone below which a branch that cannot be followed on is taken to end at grazing."""

_AT_A_FOLD = 1e-3
"""How far above 1 a multiplier may be at a fold, which is met within rounding."""

_LOCATED = 1e-5
"""The share of a step to which an end is located: at a fold the speed is stationary."""


@dataclass(frozen=True, eq=False)
class _Point:
    """An orbit as a point of the branch: six states and the speed reference, in their own units, and the direction."""

    place: FloatArray
    direction: FloatArray
    passage: Passage
    rounds: int

    @property
    def is_stable(self) -> bool:
        """Whether all multipliers but the trivial one lie inside the unit circle."""
        values = self.passage.multipliers
        return bool(np.all(np.abs(np.delete(values, int(np.argmin(np.abs(values - 1.0))))) < 1.0))

    @property
    def rises(self) -> bool:
        """Whether the branch is on its way to higher speeds."""
        return bool(self.direction[-1] > 0.0)


def end_of_branch(
    returns: ReturnMap, speed_reference: float, orbit: Passage, shortest_step: float = SHORTEST_STEP
) -> tuple[float, Kind]:
    """The speed reference (rad/s) at which the branch of a stable stick-slip orbit ends, and how.

    `orbit` is its return to the section at `speed_reference` (rad/s), `shortest_step` the share of the speed below
    which a branch counts as one that cannot be followed on. Where it loses its stability on the way and does not come
    by it again, the end is where it does.
    """
    speed_unit, up = units_of(returns.rig).speed, np.eye(7)[6]
    point = _corrected(returns, _place(returns, orbit.state, speed_reference), up)
    if point is None or not point.rises or not point.is_stable:
        return speed_reference, "lost"
    step, last_stable = _FIRST_STEP, (point, 0.0)
    for _ in range(_MOST_STEPS):
        length = step * point.place[-1] / max(point.direction[-1], 1e-3)
        after = _corrected(returns, point.place + length * point.direction, point.direction)
        if after is not None and not after.rises:
            share, last = _turn(returns, point, length)
            if np.all(np.abs(last.passage.multipliers) < 1.0 + _AT_A_FOLD):
                return float(last.place[-1] * speed_unit), "fold"
            lost = _loss(returns, *((point, share * length) if point.is_stable else last_stable))
            return float(lost * speed_unit), "other"
        if after is None:
            step *= 0.5
            if step < shortest_step:
                break
            continue
        if point.is_stable and not after.is_stable:
            last_stable = point, length
        point, step = after, min(1.5 * step, _LONGEST_STEP) if after.rounds <= _EASY else step
    kind: Kind = "lost" if point.passage.stuck > _HARDLY_STUCK else "grazing" if point.is_stable else "other"
    end = _loss(returns, *last_stable) if kind == "other" else point.place[-1]
    return float(end * speed_unit), kind


def orbit_on_branch(returns: ReturnMap, speed_reference: float, orbit: Passage, wanted: float) -> Passage | None:
    """The return to itself of the orbit at another speed reference, `wanted` (rad/s), on the branch of an orbit.

    `orbit` is its return to the section at `speed_reference` (rad/s). None where the branch turns back before.
    """
    goal = wanted / units_of(returns.rig).speed
    onwards = np.eye(7)[6] * (1.0 if wanted > speed_reference else -1.0)
    point, step = _corrected(returns, _place(returns, orbit.state, speed_reference), onwards), _FIRST_STEP
    while point is not None and step > SHORTEST_STEP:
        ahead, gained = goal - point.place[-1], point.direction[-1]
        length = step * point.place[-1] / max(abs(gained), 1e-3)
        is_last = abs(ahead) <= length * abs(gained)
        predicted = point.place + (ahead / gained if is_last else length) * point.direction
        after = _corrected(returns, predicted, onwards if is_last else point.direction)
        if after is not None and is_last:
            return after.passage
        if after is not None and after.direction[-1] * onwards[-1] <= 0.0:
            return None
        if after is None or (goal - after.place[-1]) * onwards[-1] <= 0.0:
            step *= 0.5
        else:
            point, step = after, min(1.5 * step, _LONGEST_STEP)
    return None


def _turn(returns: ReturnMap, point: _Point, length: float) -> tuple[float, _Point]:
    """The share of a `length` from a point at which the branch turns back, and the last orbit found before."""
    before, last = 0.0, point

    def upwards(share: float) -> float:
        nonlocal before, last
        found = _corrected(returns, point.place + share * length * point.direction, point.direction)
        if found is not None and found.rises and share >= before:
            before, last = share, found
        return float(found.direction[-1]) if found else -1.0

    brentq(upwards, 0.0, 1.0, xtol=_LOCATED)
    return before, last


def _loss(returns: ReturnMap, point: _Point, length: float) -> float:
    """The speed, in its unit, at which the branch loses its stability within a `length` from a point."""
    low, high = 0.0, 1.0
    while high - low > _LOCATED:
        middle = 0.5 * (low + high)
        found = _corrected(returns, point.place + middle * length * point.direction, point.direction)
        low, high = (middle, high) if found and found.is_stable else (low, middle)
    return float((point.place + low * length * point.direction)[-1])


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
