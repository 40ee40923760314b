"""A recorded run in the lanes again: its actions as a policy, and what was given as a plan."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import Actions, Observations
from drillrig_env.course import COLUMNS
from drillrig_env.env.recorded import Recorded
from drillrig_env.env.task import Task
from drillrig_env.policy.contract import Memory
from drillrig_env.room.lane import Lane


class Replayed:
    """A policy that takes the actions of a recorded lane one after the other, and 0 when they are at an end."""

    def __init__(self, actions: npt.NDArray[np.float32]) -> None:
        self._actions, self._step = actions, 0

    def predict(
        self,
        observation: Observations,
        state: Memory = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Memory]:
        """The next action, shape (1, 1)."""
        action = self._actions[self._step] if self._step < len(self._actions) else np.zeros(1, np.float32)
        self._step += 1
        return action[None], None


def lanes_of(recorded: Recorded) -> list[Lane]:
    """The lanes of a recorded run, at its start. Raises `ValueError` for what the environment refuses."""
    lanes = []
    for name in recorded.lanes:
        task = Task.of(None, **recorded.environment(name))
        lanes.append(Lane(task, Replayed(recorded.actions(name)), name, recorded.seed, recorded.start))
    return lanes


def plan_of(recorded: Recorded) -> dict[int, dict[str, float]]:
    """What is given in a recorded run, by the control step from which on it holds."""
    period = Task.for_rig(recorded.rig).control_period
    table = recorded.course.table(period * np.arange(max(recorded.steps, 1), dtype=float))
    plan = {0: dict(zip(COLUMNS, table[0].tolist(), strict=True))}
    for step in np.flatnonzero(np.any(table[1:] != table[:-1], axis=1)) + 1:
        plan[int(step)] = dict(zip(COLUMNS, table[step].tolist(), strict=True))
    return plan
