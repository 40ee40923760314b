"""Jump and ease told nothing: the same law on a friction that is estimated from what the sensors show.

Two torques give most of it away. The bit breaks loose at N_1 r_1 mu_s, the largest torque that the
shaft carries while the bit is stuck; and in calm rotation at a known speed the shaft carries
T_r1 = N_1 r_1 [mu_k + (mu_s - mu_k) exp(-v_b omega)] (4-7). The decay v_b is seen by neither.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from baselines.jump_ease import JumpEase
from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.rig import RigLike
from drillrig_env.stability import fold_speed
from drillrig_env.verdict import STUCK_SPEED

_BREAK_LOOSE, _STEADY, _AT = 2, 3, 4  # columns of memory after those of JumpEase


class JumpEaseEstimated(JumpEase):
    """Jump and ease on an estimated friction, told nothing; needs bit and collar speed and the upper twist.

    Until the bit has stuck once, the load is taken from the torque of the shaft as it is. The ratio
    mu_k / mu_s is that of the nominal friction until calm rotation has shown a steady torque. The margin for what is
    not seen: the fold that it jumps past is the largest over v_b within 1 +- `spread` of the nominal one, and
    mu_k is taken lower by `spread` until it is seen. It eases down to the critical speed of the nominal
    v_b; where that was too low the rig begins to shake, and the jump is repeated. Seen ten times a
    second, the break-loose torque is uncertain by half of what the shaft winds up in a step: little at
    20 N, a quarter at 8 N and 4 rad/s. `spread` 0.1 was the best of 0.1, 0.2 and 0.3 on draws of the
    default scenario with seeds that no suite uses.
    """

    channels = (
        *JumpEase.channels,
        "bit_speed",
        "top_speed",
        "twist_12",
        "collar_speed",
        "bit_speed_deviation",
        "bit_speed_mean",
    )
    any_of = ()
    privileged = ()
    memory = 5  # JumpEase's two; break-loose torque; steady torque, and the speed that it was seen at

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        spread: float = 0.1,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        self.check_chapters_law()
        self.spread = spread

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The law of JumpEase: past the highest fold that the estimates allow, down to the likeliest critical speed."""
        self._watch(seen, memory)
        estimates = self.estimates(memory)
        folds = [np.nan_to_num(fold_speed(self.plant, friction)) for friction in estimates]
        course = self._course(self.plant, estimates[0], seen["speed_target"], np.max(folds, axis=0))
        return self._follow(seen, course, memory[:, :2])

    def estimates(self, memory: FloatArray) -> list[Friction]:
        """The frictions that the torques seen so far allow, one for each decay v_b that is considered.

        `memory` is the law's, shape (n, numbers).
        """
        static = memory[:, _BREAK_LOOSE]
        likely_mu_s, likely_mu_k, likely_v_b = self.nominal_friction.as_array(1)[0, 1:].tolist()
        found = []
        for v_b in likely_v_b * np.array([1.0, 1.0 - self.spread, 1.0 + self.spread]):
            decayed = np.exp(-v_b * memory[:, _AT])
            kinetic = np.where(
                memory[:, _AT] > 0,
                (memory[:, _STEADY] - static * decayed) / np.maximum(1.0 - decayed, 1e-3),
                static * (1.0 - self.spread) * likely_mu_k / likely_mu_s,
            )
            kinetic = np.clip(kinetic, 0.0, static)
            force = static / (self.plant.r_1 * likely_mu_s)
            ratio = np.where(static > 0, kinetic / np.maximum(static, 1e-9), likely_mu_k / likely_mu_s)
            mu_s = np.full(len(force), likely_mu_s)
            found.append(Friction(force, mu_s, likely_mu_s * ratio, np.full(len(force), v_b)))
        return found

    def _watch(self, seen: Mapping[str, FloatArray], memory: FloatArray) -> None:
        """Keep the largest torque while stuck, and the torque of the calmest rotation so far."""
        rig = self.plant
        torque = -rig.k_1 * seen["twist_12"] - rig.d_1 * (seen["bit_speed"] - seen["collar_speed"])
        torque = torque - rig.C_1 * seen["bit_speed"]
        stuck = seen["bit_speed"] < STUCK_SPEED
        winding = rig.k_1 * rig.k_2 / (rig.k_1 + rig.k_2) * seen["top_speed"] * self.period
        torque = torque + np.where(stuck, 0.5 * winding, 0.0)  # break-loose comes within the step, on average half way
        memory[:, _BREAK_LOOSE] = np.where(stuck, np.maximum(memory[:, _BREAK_LOOSE], torque), memory[:, _BREAK_LOOSE])
        unknown = memory[:, _BREAK_LOOSE] == 0.0
        memory[:, _BREAK_LOOSE] = np.where(unknown & ~stuck, np.maximum(torque, 0.0), memory[:, _BREAK_LOOSE])
        calm = seen["bit_speed_deviation"] < self.calm * seen["bit_speed_mean"]
        memory[:, _STEADY] = np.where(calm, torque, memory[:, _STEADY])
        memory[:, _AT] = np.where(calm, seen["bit_speed"], memory[:, _AT])
