"""Jump and ease: leave the stick-slip branch at its far end, then come back down on the calm one.

Between the critical speed omega_c and the fold both calm rotation and stick-slip are stable (the
chapter's figures 4.12 and 4.13). A rig in stick-slip therefore stays there when the reference is put
just above omega_c: it must pass the fold. Once calm it may come down as far as omega_c.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from math import sqrt
from typing import Any, ClassVar, NamedTuple

import numpy as np

from baselines.counted import CountedLaw
from baselines.string_torque import MEMORY, OSCILLATION_MEMORY, TORQUE_SHOWN, oscillation, torque_deviation
from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.model import jacobian, state_equations
from drillrig_env.rig import Rig, RigLike
from drillrig_env.scales import LARGEST_REFERENCE
from drillrig_env.stability import basin_depth, critical_slope, critical_speed, fold_speed

_MEAN_TIME = 10.0  # s, of the torque's mean
_FOLLOW = 0.15  # of the torque's oscillation: over about one cycle, so that noise is not taken for shaking
TWIST_RATE_TIME = 2.5  # s, of the mean square twist rate; about one stick-slip period


class Course(NamedTuple):
    """Where `JumpEase` goes: how low (rad/s), how high (rad/s), and how fast it comes down (rad/s^2); shape (n,)."""

    floor: FloatArray
    past_fold: FloatArray
    rate: FloatArray


class JumpEase(CountedLaw):
    """Jump and ease, told the friction: past the fold, wait until calm, down to max(omega*, omega_c + margin).

    Oscillation is measured as the running root mean square of the twist rate x_3 - x_5 (bit less top
    speed) over the speed reference, which the jump itself hardly excites. Where the bit speed is not
    shown, the oscillation of the torque into the string, over the string's impedance, stands for it.
    Above `shaking` the reference rises at the slew limit to (1 + `beyond`) times the fold; there it waits
    until the measure has fallen below `calm`, and then eases down.

    How fast? The corner of a ramp of rate r leaves a swing c r of the bit speed behind, with c from the
    rig's least damped pair of eigenvalues. Calm rotation survives a swing up to that of the unstable
    orbit p2, which is smallest where the ramp ends. The rate is such that c r is the share `of_basin`
    of that swing.
    """

    any_of: ClassVar[tuple[tuple[str, ...], ...]] = (("bit_speed", "top_speed"), *TORQUE_SHOWN)
    privileged: ClassVar[tuple[str, ...]] = ("normal_force", "mu_s", "mu_k", "v_b")
    memory = 2 + MEMORY + OSCILLATION_MEMORY  # mean square twist rate; 1 while easing; the torque's oscillation

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        margin: float = 0.1,
        beyond: float = 0.1,
        shaking: float = 0.1,
        calm: float = 0.05,
        of_basin: float = 0.06,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        self.margin = margin
        self.beyond = beyond
        self.shaking = shaking
        self.calm = calm
        self.of_basin = of_basin

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The law for the friction that it is told."""
        friction = Friction(**privileged, law=self.nominal_friction.law)
        return self._follow(seen, self._course(self.plant, friction, seen["speed_target"]), memory)

    def _course(self, rig: Rig, friction: Friction, target: FloatArray, fold: FloatArray | None = None) -> Course:
        """The course on a rig with a friction; `fold` (rad/s) where another is to be passed than theirs."""
        if fold is None:
            fold = np.asarray(fold_speed(rig, friction))
        floor = np.maximum(target, critical_speed(rig, friction) + self.margin)
        past_fold = np.fmin((1.0 + self.beyond) * np.nan_to_num(fold), LARGEST_REFERENCE)
        rate = self.of_basin * basin_depth(rig, friction, floor) / swing_of_a_ramp(rig)
        return Course(floor, past_fold, rate)

    def _follow(self, seen: Mapping[str, FloatArray], course: Course, memory: FloatArray) -> FloatArray:
        """Up past the fold while shaking, level until calm, then down at the safe rate to the floor."""
        reference = seen["speed_reference"]
        floor, past_fold, rate = course
        memory[:, 0] += self.followed(TWIST_RATE_TIME) * (self._twist_rate(seen, memory[:, 2:]) ** 2 - memory[:, 0])
        oscillation = np.sqrt(memory[:, 0]) / np.maximum(reference, 0.1)
        easing = np.where(memory[:, 1] > 0, oscillation < self.shaking, oscillation < self.calm)
        memory[:, 1] = easing
        lowered = reference - np.where(easing, np.minimum(rate, self.plant_slew) * self.period, 0.0)
        return np.maximum(floor, np.where(oscillation > self.shaking, np.maximum(past_fold, reference), lowered))

    def _twist_rate(self, seen: Mapping[str, FloatArray], memory: FloatArray) -> FloatArray:
        """Bit less top speed, rad/s, or a number of the same mean square from the torque's oscillation."""
        if "bit_speed" in seen and "top_speed" in seen:
            return seen["bit_speed"] - seen["top_speed"]
        deviation = torque_deviation(self.plant, seen, memory[:, :MEMORY], _MEAN_TIME, self.period)
        z = oscillation(self.plant, deviation, memory[:, MEMORY:], self.each_step(_FOLLOW), self.period)
        return np.asarray(np.abs(z) / (sqrt(2.0) * self.plant.impedance))


@lru_cache(maxsize=32)
def swing_of_a_ramp(rig: Rig) -> float:
    """Amplitude of the bit speed (rad/s) that the corner of a ramp of 1 rad/s^2 leaves behind.

    The residue of the answer to omega_ref = t at the least damped pair of eigenvalues, at the critical slope.
    """
    values, modes = np.linalg.eig(jacobian(rig, critical_slope(rig)))
    pair = int(np.argmin(np.where(values.imag > 0, np.abs(values.real), np.inf)))
    zero = [0.0] * 7
    to_rates = np.subtract(state_equations(zero, 1.0, 0.0, rig), state_equations(zero, 0.0, 0.0, rig))
    share = np.linalg.solve(modes, to_rates)[pair]
    return float(2.0 * np.abs(modes[2, pair] * share / values[pair] ** 2))
