"""Both lanes of a room: the same rig, the same draws and the same given values, two who control it; and the record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.course import COLUMNS, Course
from drillrig_env.env.recorded import Recorded, RecordedLane
from drillrig_env.friction.contact import LAWS
from drillrig_env.room.given import Given
from drillrig_env.room.lane import Lane, Shown
from drillrig_env.room.record import Record
from drillrig_env.room.setting import MOST_STEPS, Setting
from drillrig_env.room.stock import Stock

NAMES = ("A", "B")


@dataclass(frozen=True, eq=False)
class Step:
    """A control step of a run: its number, what was given, and what both lanes showed."""

    number: int
    given: FloatArray  # in the order of COLUMNS
    shown: tuple[Shown, ...]


class Lanes:
    """A run: two rigs that go step by step together.

    Raises `ValueError` for a setting that cannot be played, whatever a policy raises when it is made among it. A
    `recorded` run is played again: its actions, and what was given.
    """

    def __init__(self, setting: Setting, stock: Stock, recorded: Recorded | None = None) -> None:
        self.setting = setting = setting.at(stock)
        self.recorded, plan = recorded, {}
        if recorded is None:
            made = [
                (name, *setting.lane(policy, stock)) for name, policy in zip(NAMES, (setting.a, setting.b), strict=True)
            ]
            self.lanes = [Lane(task, policy, name, setting.seed, setting.start) for name, task, policy in made]
        else:
            from drillrig_env.room.replay import lanes_of, plan_of

            if not set(recorded.lanes) <= set(NAMES):
                names = ", ".join(recorded.lanes)[:80]
                raise ValueError(f"the recorded run: lanes {names} are not allowed; allowed: {', '.join(NAMES)}")
            self.lanes, plan = lanes_of(recorded), plan_of(recorded)
        task = self.lanes[0].task
        values = setting.values() if recorded is None else plan[0]
        self.given = Given(task, values, plan)
        self.step_number = 0
        self.broken = False  # whether a step has failed, after which the lanes are no longer at one time
        self.period = task.control_period
        self.record = Record(len(self.lanes), self.period)

    @property
    def at_end(self) -> bool:
        """Whether the run has its last control step behind it, or can have no other."""
        return self.broken or self.step_number >= (MOST_STEPS if self.recorded is None else self.recorded.steps)

    @property
    def time(self) -> float:
        """Time of the run, s."""
        return self.step_number * self.period

    def lane(self, name: Any) -> Lane:
        """A lane by name. `ValueError` for one that is not there."""
        for lane in self.lanes:
            if lane.name == name:
                return lane
        raise ValueError(f"control room: lane {name!r} is not known; allowed: {', '.join(NAMES)}")

    def step(self) -> Step:
        """One control step of both. Raises `ValueError` for what a policy raises, `NotFiniteError` for a lost state."""
        row = self.given.row(self.step_number)
        try:
            shown = tuple(lane.step(row) for lane in self.lanes)
        except Exception:
            self.broken = True
            raise
        self.record.add(row, self.lanes)
        self.step_number += 1
        return Step(self.step_number - 1, row, shown)

    def as_recorded(self) -> Recorded:
        """The run up to now, to be played again by the environment."""
        table: npt.NDArray[np.float64] = self.record.given
        if not len(table):
            raise ValueError("control room: there is nothing to keep yet; let the run take a step first")
        new = np.concatenate([[True], np.any(table[1:] != table[:-1], axis=1)])
        time = self.period * np.flatnonzero(new).astype(float)
        course = Course(time, **dict(zip(COLUMNS, table[new].T, strict=True)))
        first = self.lanes[0].task
        law = first.scenario.friction.law
        if law not in LAWS:
            raise ValueError(f"control room: a run under the law {law} of one's own cannot be written; allowed: {LAWS}")
        lanes = {
            lane.name: RecordedLane(
                policy=policy,
                sensors=lane.task.sensors.names,
                noise=float(_single(lane.task.noise)),
                delay=lane.task.delays[0],
                drive=lane.task.drive,
                taken=self.record.actions(place),
            )
            for place, (lane, policy) in enumerate(zip(self.lanes, self._policies(), strict=True))
        }
        seed, start = (self.setting.seed, self.setting.start)
        if self.recorded is not None:
            seed, start = self.recorded.seed, self.recorded.start
        return Recorded(first.rig, str(law), course, seed, start, lanes, self.setting.as_dict())

    def _policies(self) -> tuple[str, ...]:
        if self.recorded is not None:
            return tuple(lane.policy for lane in self.recorded.lanes.values())
        return self.setting.a, self.setting.b


def _single(noise: float | Mapping[str, float] | None) -> float:
    return noise if isinstance(noise, int | float) else 0.0
