"""A course: what is given over time, such as a recorded normal force, in place of what would be constant or drawn."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from drillrig_env.allowed import Allowed
from drillrig_env.arrays import FloatArray
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, closest, refuse

Values: TypeAlias = FloatArray | Sequence[float] | Callable[[float], float] | None
"""One value for each time, or a function of the time in s that gives it; None where nothing is given."""

_ALLOWED: dict[str, tuple[str, Allowed]] = {
    "normal_force": ("N", NOT_NEGATIVE),
    "mu_s": ("", NOT_NEGATIVE),
    "mu_k": ("", NOT_NEGATIVE),
    "v_b": ("s/rad", POSITIVE),
    "speed_target": ("rad/s", POSITIVE),
}
COLUMNS = tuple(_ALLOWED)
"""What a course can give, in the order of `Course.table`."""

_SHOWN = 80
"""Most characters that a message shows of what is wrong."""

_SAME = 1e-9
"""Share of a time by which one that is looked up may lie before it, in rounding."""


@dataclass(frozen=True, eq=False)
class Course:
    """Values at times (s, ascending from 0), each held until the next time, the last one to the end.

    `normal_force` N_1 in N, `mu_s` and `mu_k` (both or neither), `v_b` in s/rad and `speed_target` in rad/s are arrays
    with a value for each time, or functions of the time in s, which are sampled at these. What is not given is left to
    whoever takes the course. Raises `ValueError` for times, values or numbers of them that are not allowed.

    >>> import numpy as np
    >>> course = Course(np.arange(0.0, 60.0, 0.1), normal_force=lambda t: 20.0 + 5.0 * np.sin(0.3 * t))
    >>> course.given
    ('normal_force',)
    """

    time: FloatArray
    normal_force: Values = None
    mu_s: Values = None
    mu_k: Values = None
    v_b: Values = None
    speed_target: Values = None

    def __post_init__(self) -> None:
        time = _times(self.time)
        object.__setattr__(self, "time", time)
        for name, (unit, allowed) in _ALLOWED.items():
            if (given := getattr(self, name)) is not None:
                values = _numbers(name, unit, [given(float(t)) for t in time] if callable(given) else given)
                if values.shape != time.shape:
                    raise refuse("Course", f"shape of {name}", values.shape, "", f"{time.shape}, a value for each time")
                if not allowed.holds(values):
                    i = next(i for i, value in enumerate(values) if not allowed.holds(value))
                    raise refuse("Course", f"{name} at {time[i]:g} s", values[i], unit, allowed)
                object.__setattr__(self, name, values)
        if not self.given:
            raise refuse("Course", "what is given", "nothing", "", f"at least one of {', '.join(COLUMNS)}")
        if (self.mu_s is None) != (self.mu_k is None):
            raise refuse("Course", "what is given", ", ".join(self.given), "", "mu_s and mu_k, or neither of them")
        static, kinetic = self.values("mu_s"), self.values("mu_k")
        if static is not None and kinetic is not None and np.any(static < kinetic):
            i = int(np.argmax(static < kinetic))
            raise refuse("Course", f"mu_s at {time[i]:g} s", static[i], "", f">= mu_k = {kinetic[i]}")

    @classmethod
    def of(cls, course: Any) -> Course:
        """A course as users give it: a `Course`, a dictionary of its fields, or the path of a CSV file."""
        if isinstance(course, cls):
            return course
        if isinstance(course, str | Path):
            return cls.read(course)
        if not isinstance(course, Mapping):
            raise ValueError(f"{course!r} is not allowed; allowed: a Course, a dictionary of its fields, or a CSV file")
        known = [item.name for item in fields(cls)]
        for name in course:
            if name not in known:
                raise ValueError(f"unknown field {name!r} of a course; {closest(name, known)}")
        if "time" not in course:
            raise ValueError("the field 'time' of a course is missing: times in s, ascending from 0")
        return cls(**course)

    @classmethod
    def read(cls, path: str | Path) -> Course:
        """A course from a CSV file: a header with `time` and any of `COLUMNS`, then a line for each time.

        `path` is the file.

        Raises `ValueError` for what is no such file, naming the line, and `FileNotFoundError` where there is none.
        """
        try:
            rows = list(csv.reader(Path(path).read_text(encoding="utf-8-sig").splitlines()))
        except FileNotFoundError as error:
            raise FileNotFoundError(f"course: there is no file {path}") from error
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise ValueError(f"course: {str(path)!r} is no file that can be read: {error}") from error
        lines = [(number, row) for number, row in enumerate(rows, 1) if any(cell.strip() for cell in row)]
        header = [name.strip() for name in lines[0][1]] if lines else []
        for name in ("time", *header):
            if name not in ("time", *COLUMNS):
                raise ValueError(f"{path}: column {name!r} is not known; {closest(name, ('time', *COLUMNS))}")
            if (count := header.count(name)) != 1:
                found = ", ".join(map(repr, header))[:_SHOWN] or "nothing"
                raise ValueError(f"{path}: column {name!r} is there {count} times; allowed: once; columns: {found}")
        table = np.empty((len(lines) - 1, len(header)))
        for place, (number, row) in enumerate(lines[1:]):
            if len(row) != len(header):
                raise ValueError(f"{path}, line {number}: {len(row)} cells are not allowed; allowed: {len(header)}")
            for column, cell in enumerate(row):
                try:
                    table[place, column] = float(cell)
                except ValueError as error:
                    raise ValueError(f"{path}, line {number}: {header[column]} = {cell!r} is not a number") from error
        try:
            return cls(**dict(zip(header, table.T, strict=True)))
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error

    @property
    def given(self) -> tuple[str, ...]:
        """What it gives, of `COLUMNS`."""
        return tuple(name for name in COLUMNS if getattr(self, name) is not None)

    def values(self, name: str) -> FloatArray | None:
        """The values of one of `COLUMNS` at its times; None where it is not given. `name` is one of them."""
        found: FloatArray | None = getattr(self, name)
        return found

    def table(self, times: FloatArray) -> FloatArray:
        """The values that hold at `times` (s, shape (n,)), a column each of `COLUMNS`; NaN where none is given."""
        held = np.searchsorted(self.time, np.asarray(times) * (1.0 + _SAME), side="right") - 1
        columns = [self.values(name) for name in COLUMNS]
        return np.stack([np.full(len(held), np.nan) if given is None else given[held] for given in columns], axis=1)


def _times(given: Any) -> FloatArray:
    """The times of a course, an array of its own. `ValueError` for the first one that is not allowed."""
    time, allowed = _numbers("time", "s", given), "ascending, finite, from 0"
    if time.ndim != 1 or len(time) == 0:
        raise refuse("Course", "shape of time", time.shape, "", "(n,), one time or more")
    right = np.isfinite(time) & np.concatenate([time[:1] == 0.0, np.diff(time) > 0.0])
    if not np.all(right):
        i = int(np.argmin(right))
        raise refuse("Course", f"time {i}", time[i], "s", allowed)
    return time


def _numbers(name: str, unit: str, given: Any) -> FloatArray:
    """An array of its own, of numbers. `ValueError` where it is something else."""
    try:
        array = np.asarray(given)
        if array.dtype.kind not in "iuf":
            raise TypeError
    except (TypeError, ValueError) as error:
        allowed = f"numbers, one for each time{f', in {unit}' if unit else ''}"
        raise refuse("Course", name, repr(given)[:_SHOWN], "", allowed) from error
    return np.array(array, dtype=float)
