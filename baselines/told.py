"""Laws that are told the rig, for suites whose rigs nobody knows: what knowing would be worth.

None of them can be played on a real rig. They compete where they are asked for:
`drillrig evaluate baselines/told.py:LQGOfRig --suite unknown`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from baselines.jump_ease import Course, JumpEase
from baselines.jump_ease_estimated import JumpEaseEstimated
from baselines.lqg import LQG
from baselines.lqr import LQR, FirmLQR
from drillrig_env.arrays import FloatArray
from drillrig_env.env.sensors import Sensors
from drillrig_env.friction import Friction

__all__ = ["FirmLQROfRig", "JumpEaseOfBit", "JumpEaseOfRig", "LQGOfRig", "LQROfRig"]

_FRICTION = ("normal_force", "mu_s", "mu_k", "v_b")


class LQGOfRig(LQG):
    """`LQG` with filter and gains of the very rig, and the very law by which its friction falls; not its force.

    Where the sensors are late it takes measurements to be 2 steps old, which is the best single guess at delays of 1 to
    4 that it is not told.
    """

    privileged: ClassVar[tuple[str, ...]] = ("rig", "mu_s", "mu_k", "v_b")

    def __init__(self, sensors: str | tuple[str, ...] = "state", *given: Any, **others: Any) -> None:
        late = Sensors.named(sensors).delay > 0
        super().__init__(sensors, *given, **{"delay": 2 if late else 0, **others})

    def _law(self, privileged: Mapping[str, FloatArray]) -> Friction:
        return Friction(1.0, *(privileged[name] for name in _FRICTION[1:]), law=self.nominal_friction.law)


class LQROfRig(LQR):
    """`LQR`: the exact state, rig and friction. The ceiling."""


class FirmLQROfRig(FirmLQR):
    """`FirmLQR`: a teacher for what has to act on noisy measurements.

    Who imitates a feedback of the exact state from measurements learns the feedback of what can be known of the state;
    so the feedback has to be one that bears noise.
    """


class JumpEaseOfBit(JumpEaseEstimated):
    """`JumpEaseEstimated` with what it sees of bit and collars, and no noise; told neither rig nor friction."""

    exact: ClassVar[bool] = True


class JumpEaseOfRig(JumpEase):
    """`JumpEase` with critical speed, fold and basin of the very rig, told rig and friction."""

    privileged: ClassVar[tuple[str, ...]] = ("rig", *_FRICTION)
    memory: ClassVar[int] = JumpEase.memory + len(_FRICTION) + len(Course._fields)

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The law of JumpEase; a rig's course is found anew only when its friction is another than before."""
        told = np.stack(np.broadcast_arrays(*(privileged[name] for name in _FRICTION)), axis=-1)
        known = memory[:, JumpEase.memory :]
        kept, courses = known[:, : len(_FRICTION)], known[:, len(_FRICTION) :]
        places = np.broadcast_to(self.places(privileged), len(memory))
        anew = (kept != told).any(axis=1)
        kept[anew] = told[anew]
        for place in np.unique(places[anew]):
            chosen = np.flatnonzero(anew & (places == place))
            friction = Friction(*told[chosen].T, law=self.nominal_friction.law)
            courses[chosen] = np.stack(self._course(self.plants[place], friction, seen["speed_target"][chosen]), -1)
        return self._follow(seen, Course(*courses.T), memory)
