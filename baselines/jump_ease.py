"""Jump and ease: leave the stick-slip branch at its far end, then come back down on the calm one.

Between the critical speed omega_c and the fold both calm rotation and stick-slip are stable (the
chapter's figures 4.12 and 4.13). A rig in stick-slip therefore stays there when the reference is put
just above omega_c: it must pass the fold. Once calm it may come down as far as omega_c.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import exp

import numpy as np

from baselines.baseline import Baseline
from drillrig_env.env.kernel import CONTROL_PERIOD
from drillrig_env.friction import FloatArray, Friction
from drillrig_env.rig import Rig
from drillrig_env.stability import critical_speed

_FILTER = 1.0 - exp(-CONTROL_PERIOD / 2.5)  # of the mean square twist rate; about one stick-slip period


class JumpEase(Baseline):
    """Jump and ease, told the friction: raises omega_ref until calm, then eases to max(omega*, omega_c + margin).

    Oscillation is measured as the running root mean square of the twist rate x_3 - x_5 (bit less top
    speed) over the speed reference, which the jump itself hardly excites. Above `shaking` the
    reference rises at the slew limit; it is held until the measure has fallen below `calm`, and then
    lowered at `ease_rate` (rad/s^2). Law and margin are simple: nothing is tuned to a suite.
    """

    channels = ("speed_reference", "speed_target", "bit_speed", "top_speed")
    told = ("normal_force", "mu_s", "mu_k", "v_b")
    memory = 2  # mean square twist rate; 1 while easing

    def __init__(
        self,
        sensors: str = "state",
        rig: Rig | None = None,
        slew_limit: float = 2.0,
        ease_rate: float = 0.4,
        margin: float = 0.1,
        shaking: float = 0.1,
        calm: float = 0.03,
    ) -> None:
        super().__init__(sensors, rig, slew_limit)
        self.ease_rate = ease_rate
        self.margin = margin
        self.shaking = shaking
        self.calm = calm

    def desired_reference(
        self, seen: Mapping[str, FloatArray], told: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """Up at the slew limit while shaking, level until calm, then down at the ease rate to the floor."""
        reference = seen["speed_reference"]
        floor = np.maximum(seen["speed_target"], critical_speed(self.rig, Friction(**told)) + self.margin)
        memory[:, 0] += _FILTER * ((seen["bit_speed"] - seen["top_speed"]) ** 2 - memory[:, 0])
        oscillation = np.sqrt(memory[:, 0]) / np.maximum(reference, 0.1)
        easing = np.where(memory[:, 1] > 0, oscillation < self.shaking, oscillation < self.calm)
        memory[:, 1] = easing
        lowered = reference - np.where(easing, self.ease_rate * CONTROL_PERIOD, 0.0)
        return np.where(oscillation > self.shaking, np.inf, np.maximum(floor, lowered))
