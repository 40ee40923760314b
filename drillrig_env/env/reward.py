"""The reward: variance of the bit speed, tracking of the target, and the cost of moving the reference.

With m and V the exponentially weighted mean and variance of the bit speed,

    reward = - w_V V / omega*^2 - w_m e^2 - w_a a^2,   e = (m - omega*) / omega*,

or |e| in place of e^2 and sqrt(V) / omega* in place of V / omega*^2. Squares are nearly flat where the
scores decide (5 % off the target, a swing of 10 %); absolute values are not. Calm rotation at the target
scores 0. Variance alone would be won by standing still or by racing away; the second term stands
against both.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Literal

from drillrig_env.jit.compiled import inlined
from drillrig_env.parameters import NOT_NEGATIVE, POSITIVE, refuse

TERMS = ("variance", "tracking", "action")
"""Names of the reward's terms, in the order of `reward_terms`."""


@dataclass(frozen=True)
class Reward:
    """Weights and shape of the reward. Raises `ValueError` for a value that is not allowed."""

    variance: float = 1.0  # w_V
    tracking: float = 1.0  # w_m
    action: float = 0.01  # w_a
    variance_shape: Literal["square", "absolute"] = "square"  # V, or the standard deviation
    tracking_shape: Literal["square", "absolute"] = "square"  # e^2, or |e|
    time_constant: float = 2.5  # s, of the running mean and variance: about one stick-slip period

    def __post_init__(self) -> None:
        for name in TERMS:
            if not NOT_NEGATIVE.holds(getattr(self, name)):
                raise refuse("Reward", name, getattr(self, name), "", NOT_NEGATIVE)
        if not POSITIVE.holds(self.time_constant):
            raise refuse("Reward", "time_constant", self.time_constant, "s", POSITIVE)
        for name in ("variance_shape", "tracking_shape"):
            if getattr(self, name) not in ("square", "absolute"):
                raise refuse("Reward", name, repr(getattr(self, name)), "", "'square' or 'absolute'")


@inlined
def update_statistics(mean: float, variance: float, bit_speed: float, gain: float) -> tuple[float, float]:
    """Running mean and variance after one more sample; `gain` = 1 - exp(-sample period / time constant)."""
    deviation = bit_speed - mean
    step = gain * deviation
    return mean + step, (1.0 - gain) * (variance + deviation * step)


@inlined
def reward_terms(
    mean: float,
    variance: float,
    target: float,
    action: float,
    variance_weight: float,
    tracking_weight: float,
    action_weight: float,
    deviation: bool,
    absolute: bool,
) -> tuple[float, float, float]:
    """The three terms of the reward, each zero or negative; with the standard `deviation`, the `absolute` error."""
    error = (mean - target) / target
    swing = variance / (target * target)
    tracking = abs(error) if absolute else error * error
    return (
        -variance_weight * (sqrt(swing) if deviation else swing),
        -tracking_weight * tracking,
        -action_weight * action * action,
    )
