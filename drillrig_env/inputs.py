"""The inputs of a simulation over time: speed reference, normal force and coefficients, constant from time to time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.course import COLUMNS, Course
from drillrig_env.friction import Friction
from drillrig_env.parameters import NOT_NEGATIVE, refuse

Schedule: TypeAlias = float | Sequence[tuple[float, float]]
"""A constant, or (time in s, value) pairs: each value holds from its time on; the first time is 0."""

_OF_FRICTION = ("normal_force", "mu_s", "mu_k", "v_b")


@dataclass(frozen=True, eq=False)
class Inputs:
    """Speed reference and friction of one rig over time."""

    friction: Friction  # of the rig, where nothing else is given
    references: list[tuple[float, float]]
    forces: list[tuple[float, float]]
    course: Course | None

    @classmethod
    def of(cls, friction: Friction, reference: Schedule, force: Schedule | None, course: Any) -> Inputs:
        """Inputs as `simulate` takes them. Raises `ValueError` for what is not allowed, or is given twice."""
        course = None if course is None else Course.of(course)
        given = () if course is None else course.given
        if "speed_target" in given:
            raise ValueError("simulate: a course with a speed_target is for an environment; give the speed_reference")
        if force is not None and "normal_force" in given:
            raise ValueError("simulate: the course gives the normal_force already; leave normal_force out")
        own = float(friction.as_array()[0, 0])
        return cls(
            friction,
            _read("speed_reference", reference, "rad/s"),
            _read("normal_force", own if force is None else force, "N"),
            course,
        )

    def pieces(self, time: FloatArray, same: float) -> Pieces:
        """The intervals between the samples at `time` (s), cut where something changes in between.

        Times less than `same` (s) apart are one.
        """
        switches = self.switches[self.switches < time[-1] - same]
        later = np.searchsorted(time, switches)
        apart = np.minimum(time[later] - switches, switches - time[np.maximum(later - 1, 0)])
        stops = np.union1d(time, switches[apart > same])
        intervals = np.diff(stops)
        intervals[np.abs(intervals - time[1]) <= same] = time[1]  # differences of times round, which would add up
        held = np.concatenate([[0.0], switches[(switches > same) & (switches < time[-1] - same)]])
        which = np.searchsorted(held, stops[:-1] + same, side="right") - 1
        references, coefficients = self.reference(held, same), self.coefficients(held, same)
        return Pieces(stops, intervals, which, references, coefficients, self.friction.law)

    @property
    def switches(self) -> FloatArray:
        """The times (s) at which something may change, ascending."""
        of_course = np.empty(0) if self.course is None else self.course.time
        return np.union1d([t for t, _ in self.references + self.forces], of_course)

    def reference(self, times: FloatArray, same: float) -> FloatArray:
        """The speed reference (rad/s) at `times` (s); a switch less than `same` (s) later has been."""
        return _values_at(self.references, times, same)

    def force(self, times: FloatArray, same: float) -> FloatArray:
        """N_1 (N) at `times`, without that of a tilt."""
        if self.course is None:
            return _values_at(self.forces, times, same)
        return self.coefficients(times, same)[:, 0]

    def coefficients(self, times: FloatArray, same: float) -> FloatArray:
        """N_1, mu_s, mu_k and v_b at `times`, shape (n, 4)."""
        table = self.friction.as_array(len(times)).copy()
        table[:, 0] = _values_at(self.forces, times, same)
        if self.course is not None:
            given = self.course.table(times + same)[:, [COLUMNS.index(name) for name in _OF_FRICTION]]
            table = np.where(np.isnan(given), table, given)
        return table


@dataclass(frozen=True, eq=False)
class Pieces:
    """The intervals of a run, n of them, and the m pieces that they belong to: in each something else holds."""

    stops: FloatArray  # (n + 1,), s: where they begin, and where the last one ends
    intervals: FloatArray  # (n,), s: their lengths
    which: npt.NDArray[np.intp]  # (n,): the piece of each
    references: FloatArray  # (m,), rad/s
    coefficients: FloatArray  # (m, 4): N_1, mu_s, mu_k and v_b
    law: Any  # of friction

    @property
    def friction(self) -> Friction:
        """The friction of the pieces, an entry each."""
        return Friction(*self.coefficients.T, law=self.law)

    @property
    def changes(self) -> list[int]:
        """The intervals with which a piece begins."""
        return [0, *(np.flatnonzero(np.diff(self.which)) + 1).tolist()]

    def angles(self, states: FloatArray) -> FloatArray:
        """theta_1 (rad) at the first stops, from the states there, shape (m, 7); it begins at 0.

        The drive's integrator holds the integral of omega_ref - x_5, so that theta_1 is that of omega_ref, and
        x_1 + x_2 - x_7, less what these were at the start.
        """
        steps = len(states) - 1
        held = np.concatenate([[0.0], np.cumsum(self.references[self.which[:steps]] * self.intervals[:steps])])
        turned = states[:, 0] + states[:, 1] - states[:, 6]
        return np.asarray(held + turned - turned[0])


def _read(name: str, schedule: Schedule, unit: str) -> list[tuple[float, float]]:
    if isinstance(schedule, int | float | np.number):
        schedule = [(0.0, float(schedule))]
    pairs = [(float(time), float(value)) for time, value in schedule]
    if not pairs or pairs[0][0] != 0.0:
        first = pairs[0][0] if pairs else "none"
        raise refuse("simulate", f"first time of {name}", first, "s", "0")
    times = [t for t, _ in pairs]
    if not all(np.isfinite(times)) or any(b <= a for a, b in pairwise(times)):
        raise refuse("simulate", f"times (s) of {name}", times, "", "ascending, finite")
    for _, value in pairs:
        if not NOT_NEGATIVE.holds(value):
            raise refuse("simulate", name, value, unit, NOT_NEGATIVE)
    return pairs


def _values_at(schedule: list[tuple[float, float]], times: FloatArray, same: float) -> FloatArray:
    starts, values = np.array(schedule).T
    return np.asarray(values[np.searchsorted(starts, times + same, side="right") - 1])
