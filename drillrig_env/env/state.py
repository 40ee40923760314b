"""Everything that the coming steps of some rigs depend on, to come back to: for search, planning and safekeeping."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.env.task import CHANGEABLE, TASK_FIELDS, Task
from drillrig_env.rig import Rig


@dataclass(frozen=True, eq=False)
class EnvironmentState:
    """What `get_state` gives and `set_state` takes: a copy, which no step changes. It can be pickled.

    From it an environment of the same form and task goes on bit for bit, noise, delays and coming draws included.
    Scenario, reward, slew limit, noise and delay are those of the state again.
    """

    form: str  # what it is a state of: a class, and its way to begin episodes
    task: Task
    steps: int  # of an episode
    episodes: np.ndarray  # records of `drillrig_env.env.episode.EPISODE`, one a rig
    past: npt.NDArray[np.float32]  # measurements that are still to be seen
    observations: npt.NDArray[np.float32]  # (rigs, channels)
    own: Mapping[str, Any] = field(default_factory=dict)  # what only this form has: generators, sums of rewards
    guests: tuple[Rig, ...] = ()  # rigs beyond the scenario's

    def check(self, task: Task, steps: int, episodes: np.ndarray, past: npt.NDArray[np.float32]) -> None:
        """Raise `ValueError` where this is no state of such an environment, with what differs."""
        for name in TASK_FIELDS if self.task is not task else ():
            was, now = getattr(self.task, name), getattr(task, name)
            if name not in CHANGEABLE and was != now:
                raise ValueError(f"set_state: the state's {name} = {was} is not allowed; allowed: {now}")
        if self.steps != steps:
            raise ValueError(f"set_state: a state of episodes of {self.steps} steps is not allowed; allowed: {steps}")
        if self.episodes.dtype != episodes.dtype:
            raise ValueError("set_state: the state was made by another version of drillrig_env")
        if len(self.episodes) != len(episodes):
            raise ValueError(
                f"set_state: a state of {len(self.episodes)} rigs is not allowed; allowed: {len(episodes)}"
            )
        if self.past.shape[1] != past.shape[1]:
            late, allowed = (max(0, one.shape[1] - 1) for one in (self.past, past))
            raise ValueError(
                f"set_state: a state of delays up to {late} control steps is not allowed; allowed: up to {allowed}"
            )


def checked_state(state: Any, form: str) -> EnvironmentState:
    """A state of this form. Raises `ValueError` for anything else."""
    if not isinstance(state, EnvironmentState):
        raise ValueError(f"set_state: {state!r} is not allowed; allowed: what get_state() gives")
    if state.form != form:
        raise ValueError(f"set_state: a state of {state.form} is not allowed; allowed: one of {form}")
    return state
