"""LQR: state feedback about a raised set point, told all that there is to know. A ceiling, not a controller."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from baselines.counted import CountedLaw
from baselines.lqg import TWIST_RATE_TIME, move_of_set_point
from baselines.set_point_feedback import SetPointFeedback, wanted_change
from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.model import STATE_NAMES
from drillrig_env.rig import RigLike
from drillrig_env.scales import LARGEST_REFERENCE

_STEPS, _OFFSET, _SHAKING = 0, 1, 2
_HIGHEST_SET_POINT = LARGEST_REFERENCE - 0.5  # rad/s; little room is enough for a feedback that is told everything

ENTRIES = 41
"""Entries of the gains of each rig, over the slope of the friction."""


class LQR(CountedLaw):
    """LQ feedback of the exact state about a set point that is raised while the rig shakes; told rig and friction.

    What `LQG` does with estimates on one design for all rigs, this does with the state, the rig and the friction as
    they are: the feedback (`baselines.set_point_feedback`) is that of the very rig at the very slope of its friction,
    about the steady state that belongs to the set point. As long as the running twist rate (bit less top speed, over
    the set point) is above `shaking`, the set point rises at `rise` (rad/s^2) above the target; once calm it comes down
    at `ease`. What this cannot free no law of the speed reference is likely to.

    With a `calm_effort` the `effort` weighs less the nearer the rig comes to `calm`: what is left of the swing there is
    what noise makes of it, where the state is estimated, and a firm hand keeps it smallest.

    Tuning rule: `effort`, `shaking` and `ease` were chosen among a few on fleets that nothing is judged on.
    """

    channels: ClassVar[tuple[str, ...]] = (*STATE_NAMES, "speed_reference", "speed_target")
    privileged: ClassVar[tuple[str, ...]] = ("rig", "normal_force", "mu_s", "mu_k", "v_b")
    exact: ClassVar[bool] = True
    memory: ClassVar[int] = 3

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        effort: float = 100.0,
        shaking: float = 0.3,
        rise: float = 2.0,
        ease: float = 0.5,
        calm_effort: float | None = None,
        calm: float = 0.15,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        self.shaking, self.rise, self.ease, self.calm = shaking, rise, ease, calm
        self.feedback = self.calm_feedback = SetPointFeedback(self.plants, effort, self.period, ENTRIES)
        if calm_effort is not None:
            self.calm_feedback = SetPointFeedback(self.plants, calm_effort, self.period, ENTRIES)

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The reference so far, the move of the set point, and the change that the feedback asks for."""
        friction = Friction(
            *(privileged[name] for name in ("normal_force", "mu_s", "mu_k", "v_b")), law=self.nominal_friction.law
        )
        twist_rate = seen["bit_speed"] - seen["top_speed"]
        memory[:, _SHAKING] += self.followed(TWIST_RATE_TIME) * (twist_rate**2 - memory[:, _SHAKING])
        set_point = seen["speed_target"] + memory[:, _OFFSET]
        shaking = np.sqrt(memory[:, _SHAKING]) / set_point
        rate = np.where(shaking > self.shaking, self.rise, -self.ease)
        wanted, time = rate * self.period, memory[:, _STEPS] * self.period
        move = move_of_set_point(wanted, set_point, memory[:, _OFFSET], time, _HIGHEST_SET_POINT)
        memory[:, _OFFSET] += move
        memory[:, _STEPS] += 1.0
        states = np.stack([seen[name] for name in STATE_NAMES], axis=-1)
        reference = seen["speed_reference"] + move
        feedback = self._feedback(friction, set_point + move, self.places(privileged), shaking)
        return np.asarray(reference + wanted_change(feedback, states, reference))

    def _feedback(
        self, friction: Friction, set_point: FloatArray, places: npt.NDArray[np.intp], shaking: FloatArray
    ) -> FloatArray:
        """The feedback about set points (rad/s) of shape (n,), where the rigs shake so much; shape (n, SIZE + 1)."""
        found = self.feedback.at(friction, set_point, places)
        if self.calm_feedback is self.feedback:
            return found
        share = np.clip((shaking - self.calm) / (self.shaking - self.calm), 0.0, 1.0)[:, None]
        firm = self.calm_feedback.at(friction, set_point, places)
        return np.asarray(firm + share * (found - firm))


class FirmLQR(LQR):
    """`LQR` with efforts that bear noise: firm near calm, for a state that is known only from measurements.

    Tuning rule: `effort` and `calm_effort` were chosen among a few on a fleet to tune on, for `LQROnEnsemble`.
    """

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        effort: float = 30.0,
        calm_effort: float = 0.3,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, effort, calm_effort=calm_effort, **others)
