"""What all baselines share: a law for the speed reference behind Stable-Baselines3's `predict`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from drillrig_env.env.kernel import CONTROL_PERIOD
from drillrig_env.env.sensors import Sensors
from drillrig_env.friction import FloatArray
from drillrig_env.rig import Rig


class Baseline(ABC):
    """A policy that names the speed reference it wants; the action is the rate that gets there.

    Subclasses give `desired_reference`, the `channels` that they read, the width of their `memory`
    and, in `told`, what they must be told beyond the sensors: the names of entries of `info`, handed
    over by `tell(info)` before each `predict`.
    """

    channels: ClassVar[tuple[str, ...]] = ("speed_reference", "speed_target")
    told: ClassVar[tuple[str, ...]] = ()
    memory: ClassVar[int] = 0

    def __init__(self, sensors: str = "state", rig: Rig | None = None, slew_limit: float = 2.0) -> None:
        self.sensors = Sensors.named(sensors)
        self.rig = rig or Rig()
        self.slew_limit = slew_limit
        self._told: dict[str, FloatArray] = {}
        missing = sorted(set(self.channels) - set(self.sensors.names))
        if missing:
            raise ValueError(
                f"{type(self).__name__} reads {', '.join(missing)}, which the sensors {sensors!r} do not show"
            )

    def tell(self, info: Mapping[str, Any]) -> None:
        """Take from an environment's `info` what this policy is told; one entry a rig, or numbers."""
        self._told = {name: np.atleast_1d(np.asarray(info[name], dtype=float)) for name in self.told}

    def predict(
        self,
        observation: npt.NDArray[np.float32],
        state: tuple[np.ndarray, ...] | None = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[npt.NDArray[np.float32], tuple[np.ndarray, ...] | None]:
        """Actions for observations of shape (n, channels) or (channels,), and the policy's next state.

        `state` is what the last call returned (None at first); where `episode_start` is true it is
        begun anew. The law is deterministic whatever `deterministic` says.
        """
        batch = np.atleast_2d(observation)
        memory = np.zeros((len(batch), self.memory)) if state is None else np.array(state[0])
        if episode_start is not None:
            memory[np.asarray(episode_start, dtype=bool)] = 0.0
        seen = self.sensors.values(batch)
        if self.told and not self._told:
            raise RuntimeError(f"{type(self).__name__} is told {', '.join(self.told)}: call tell(info) before predict")
        desired = self.desired_reference(seen, self._told, memory)
        rate = (desired - seen["speed_reference"]) / (self.slew_limit * CONTROL_PERIOD)
        actions = np.clip(rate, -1.0, 1.0).astype(np.float32)[:, None]
        return (actions if np.ndim(observation) == 2 else actions[0]), (memory,)

    @abstractmethod
    def desired_reference(
        self, seen: Mapping[str, FloatArray], told: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The wanted speed reference, rad/s, shape (n,).

        `seen` and `told` hold physical values by name, shape (n,); `memory` of shape (n, memory) is
        zero when an episode begins and is changed in place.
        """
