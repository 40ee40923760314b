"""A trained agent out of its file, as a policy of the one contract: for whoever has no clone and no PyTorch."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import Actions, Observations
from drillrig_env.deploy.policy_file import PolicyFile, shipped_policies
from drillrig_env.drive import Drive
from drillrig_env.env.sensors import Sensors
from drillrig_env.policy.contract import Memory
from drillrig_env.rig import Rig


def shipped_agents() -> list[str]:
    """Names of the trained agents among the files that come with the package; its laws are installed as classes too.

    Empty where there is no onnxruntime.
    """
    try:
        return [name for name in shipped_policies() if PolicyFile(name).about["training"]["kind"] != "law"]
    except ImportError:
        return []


class ShippedAgent:
    """An agent of `drillrig_env.deploy`, for one rig; on another rig than the chapter's it sees what belongs to that.

    Raises `ImportError` without onnxruntime.
    """

    def __init__(self, name: str) -> None:
        self._file = PolicyFile(name)
        about = self._file.about
        self._slew_limit = float(about["slew_limit"]["value"])
        self._drive = Drive.of(about["drive"])
        self._channels = Sensors.named(tuple(one["name"] for one in about["channels"]))
        self.sensors = self._channels.names

    @property
    def drive(self) -> Drive | None:
        """The drive that it was trained on; None for the chapter's, in whose place there is a rig's own."""
        return None if self._drive == Drive.of_rig(Rig()) else self._drive

    def predict(
        self,
        observation: Observations,
        state: Memory = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Memory]:
        """The action, shape (1, 1), for an observation of shape (1, channels); see `drillrig_env.policy.Policy`.

        The file wants values of the chapter's rig, which an observation, free of units, tells of any rig.
        """
        if episode_start is not None and episode_start.any():
            self._file.reset()
        rates, _ = self._file.step(self._channels.values(observation))
        return np.clip(rates / self._slew_limit, -1.0, 1.0).astype(np.float32)[:, None], None
