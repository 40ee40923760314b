"""What every agent is held against: the drive that it works through, with its reference at the target."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from agents.policy.environment import task_of
from drillrig_env.arrays import FloatArray
from drillrig_env.drive import Drive

SAME_DRIVE = "action 0, same drive"
"""What tables call it."""


class ActionZero:
    """The drive of an environment, its reference at the target: the action is 0 but where the target has stepped.

    `environment` holds arguments of the environment, such as those in which an agent was trained.
    """

    privileged: ClassVar[tuple[str, ...]] = ("speed_target", "speed_reference")

    def __init__(self, environment: Mapping[str, Any]) -> None:
        self.environment = environment
        task = task_of(environment)
        self._step = task.slew_limit * task.control_period
        self._away: FloatArray = np.zeros(1)  # of the target from the reference, rad/s

    @property
    def drive(self) -> Drive | None:
        """The environment's drive; None for the rig's own."""
        return Drive.of(self.environment.get("drive"))

    def tell(self, info: Mapping[str, Any]) -> None:
        """Take note of target and reference."""
        self._away = np.asarray(info["speed_target"]) - np.asarray(info["speed_reference"])

    def predict(
        self,
        observation: npt.NDArray[np.float32],
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[np.ndarray, None]:
        """Actions (n, 1) for observations (n, channels), and (1,) for (channels,); there is no state."""
        actions = np.zeros((*np.shape(observation)[:-1], 1), np.float32)
        actions[..., 0] = np.clip(self._away / self._step, -1.0, 1.0)
        return actions, None
