"""A rig of the environment in the place of hardware, and a clock that does not wait: to try all but the wires.

It needs the whole package, unlike the rest of this folder.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.seeds import VALIDATION_SEEDS


class DryRig:
    """A rig of an episode with the instruments of the surface, noise and delay included; `Hardware` for `run_loop`.

    `rig` is a number that draws load and start, as a seed does; `task` has arguments of the environment, such as
    `rig=` and `sensors=`. `steps` is how many control steps it has done.
    """

    def __init__(self, number: int = 0, **task: Any) -> None:
        self.core = EpisodeBatch(1, **{"sensors": "surface", **task})
        self.core.reset(np.arange(1), first_uniforms(VALIDATION_SEEDS.start + number, 1))
        self.steps = 0

    @property
    def reference(self) -> float:
        """The speed reference that the drive has, rad/s."""
        return float(self.core.episodes["speed_reference"][0])

    @property
    def target(self) -> float:
        """The speed target of the episode, rad/s."""
        return float(self.core.episodes["speed_target"][0])

    @property
    def bit_speed_deviation(self) -> float:
        """The running deviation of the bit speed, rad/s: how much it sticks and slips, which no surface shows."""
        return float(np.sqrt(self.core.episodes["variance"][0]))

    def measure(self) -> dict[str, Any]:
        """What the instruments show, by channel."""
        seen = self.core.sensors.values(self.core.observations)
        own = ("speed_reference", "speed_target")
        return {
            name: float(value[0])
            for name, value in seen.items()
            if name not in own and not name.endswith(("_mean", "_deviation"))
        }

    def command(self, speed_reference: float) -> None:
        """Give the drive a speed reference (rad/s), and let a control step pass."""
        largest = self.core.slew_limit * self.core.control_period
        action = np.clip((speed_reference - self.reference) / largest, -1.0, 1.0)
        self.core.step(np.full((1, 1), action, np.float32))
        self.steps += 1


class Instant:
    """A clock that passes only while somebody sleeps: `run_loop(..., clock=instant, sleep=instant.sleep)`."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        """The time, s."""
        return self.now

    def sleep(self, seconds: float) -> None:
        """Let `seconds` pass at once."""
        self.now += seconds
