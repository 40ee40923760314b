"""What the operator gives over time: target, normal force, friction; at once, or by a ramp.

The lanes take it as a course of their scenario, of which a row holds for a control step, so that the environment plays
the same run again from what was written there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.course import COLUMNS
from drillrig_env.env.task import Task
from drillrig_env.friction import Friction
from drillrig_env.parameters import Allowed, checked, closest

UNITS = dict(zip(COLUMNS, ("N", "", "", "s/rad", "rad/s"), strict=True))
"""Of what is given, by name."""

_LARGEST = {"normal_force": 1e4, "mu_s": 100.0, "mu_k": 100.0, "v_b": 1e4}
"""Largest values on the chapter's rig, in their units: what is far beyond them no computer adds up any more."""

_LONGEST_RAMP = 600.0
"""Longest time of a ramp on the chapter's rig, s."""


@dataclass(frozen=True)
class _Ramp:
    """From one value to another between two control steps."""

    first: int
    steps: int
    start: float
    end: float

    def at(self, step: int) -> float:
        """The value that holds in a control step."""
        share = min((step + 1 - self.first) / self.steps, 1.0)
        return self.start + share * (self.end - self.start) if share < 1.0 else self.end


class Given:
    """The values of `drillrig_env.course.COLUMNS` now, the ramps under way, and what is planned for later.

    `values` are the first ones by name; `plan` has, by control step, values that then come by themselves.
    """

    def __init__(self, task: Task, values: dict[str, float], plan: dict[int, dict[str, float]] | None = None) -> None:
        self._task = task
        scales = task.scales
        grown = {"normal_force": scales.force, "v_b": 1.0 / scales.speed}
        largest = {name: float(f"{most * grown.get(name, 1.0):.2g}") for name, most in _LARGEST.items()}
        self._allowed = {name: Allowed(0.0, most, low_open=name == "v_b") for name, most in largest.items()}
        self._allowed["speed_target"] = task.targets
        self.values = {name: values[name] for name in COLUMNS}
        self._ramps: dict[str, _Ramp] = {}
        self._plan = dict(plan or {})
        for planned in ({}, *self._plan.values()):
            self._check({**self.values, **planned})

    def set(self, changes: Mapping[str, float | str]) -> None:
        """Take values from the coming control step on. `ValueError` with the rig's own sentence; then nothing changes.

        A ramp of such a value ends.
        """
        for name in changes:
            if name not in COLUMNS:
                raise ValueError(f"control room: unknown value {name!r}; {closest(name, COLUMNS)}")
        values = {**self.values, **changes}
        self._check(values)
        self.values = {name: float(value) for name, value in values.items()}
        for name in changes:
            self._ramps.pop(name, None)

    def ramp(self, name: str, to: float | str, seconds: float | str, step: int) -> None:
        """Go to a value within so many seconds (s), from control step `step` on. `ValueError` as for `set`."""
        longest = _LONGEST_RAMP * self._task.scales.time
        lasts: float = checked("control room", "time of a ramp", seconds, "s", Allowed(0.0, longest, low_open=True))
        if name not in COLUMNS:
            raise ValueError(f"control room: unknown value {name!r}; {closest(name, COLUMNS)}")
        self._check({**self.values, name: to})
        steps = max(round(lasts / self._task.control_period), 1)
        self._ramps[name] = _Ramp(step, steps, self.values[name], float(to))

    @property
    def ramps(self) -> dict[str, float]:
        """Where the ramps under way lead, by name."""
        return {name: ramp.end for name, ramp in self._ramps.items()}

    def row(self, step: int) -> FloatArray:
        """The values of a control step, in the order of `COLUMNS`; called once for each, one after the other."""
        if step in self._plan:
            self.values.update(self._plan[step])
        for name, ramp in list(self._ramps.items()):
            self.values[name] = ramp.at(step)
            if self.values[name] == ramp.end:
                del self._ramps[name]
        return np.array(list(self.values.values()))

    def friction(self) -> Friction:
        """The friction that is given now, under the task's law."""
        given = self.values
        law = self._task.scenario.friction.law
        return Friction(given["normal_force"], given["mu_s"], given["mu_k"], given["v_b"], law=law)

    def _check(self, values: Mapping[str, Any]) -> None:
        for name in reversed(COLUMNS):
            checked("control room", name, values[name], UNITS[name], self._allowed[name])
        Friction(values["normal_force"], values["mu_s"], values["mu_k"], values["v_b"])
