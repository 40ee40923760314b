"""A rig of the environment as hardware: what its instruments show, and a drive that takes a speed reference."""

import numpy as np

from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.seeds import VALIDATION_SEEDS

SHOWN = ("top_speed", "current", "voltage", "string_torque")


class Bench:
    """One rig with the surface's instruments, with their noise and delay; `step` is how many steps were done."""

    def __init__(self, rig=0, **task):
        self.core = EpisodeBatch(1, **{"sensors": "surface", **task})
        self.core.reset(np.arange(1), first_uniforms(VALIDATION_SEEDS.start + rig, 1))
        self.step = 0

    @property
    def reference(self):
        return float(self.core.episodes["speed_reference"][0])

    @property
    def target(self):
        return float(self.core.episodes["speed_target"][0])

    def measure(self):
        seen = self.core.sensors.values(self.core.observations)
        return {name: float(seen[name][0]) for name in SHOWN}

    def command(self, reference):
        largest = self.core.slew_limit * self.core.control_period
        action = np.clip((reference - self.reference) / largest, -1.0, 1.0)
        self.core.step(np.full((1, 1), action, np.float32))
        self.step += 1
