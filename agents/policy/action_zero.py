"""What every agent is held against: the drive that it works through, with a reference that nobody moves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.drive import Drive

SAME_DRIVE = "action 0, same drive"
"""What tables call it."""


class ActionZero:
    """The action 0 in every step, on the drive of an environment: the reference stays at the target.

    `environment` holds arguments of the environment, such as those in which an agent was trained.
    """

    def __init__(self, environment: Mapping[str, Any]) -> None:
        self.environment = environment

    @property
    def drive(self) -> Drive | None:
        """The environment's drive; None for the rig's own."""
        return Drive.of(self.environment.get("drive"))

    def predict(
        self,
        observation: npt.NDArray[np.float32],
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[np.ndarray, None]:
        """Zeros of shape (n, 1) for observations (n, channels), and (1,) for (channels,); there is no state."""
        return np.zeros((*np.shape(observation)[:-1], 1), np.float32), None
