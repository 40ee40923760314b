"""The reward in compiled code: running statistics of the bit speed, and the terms that come of them."""

from __future__ import annotations

from math import sqrt

from drillrig_env.env.reward import CALM_SWING
from drillrig_env.jit.compiled import inlined

_SLOW = 0.3  # share of the target below which a mean counts as standing, more and more
_LARGEST_SWING, _LARGEST_ERROR = 1.5, 2.0  # beyond these, worse is not told from bad
_SMALL_ERROR = 0.05  # at which half of what being on target is worth is there


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
    phases: bool,
    tracking_swing: float,
) -> tuple[float, float, float]:
    """The three terms of the reward, each zero or negative; with the standard `deviation`, the `absolute` error."""
    if phases:
        shaking, off = _phases(mean, variance, target, tracking_swing)
        return -variance_weight * shaking, -tracking_weight * off, -action_weight * action * action
    error = (mean - target) / target
    swing = variance / (target * target)
    tracking = abs(error) if absolute else error * error
    return (
        -variance_weight * (sqrt(swing) if deviation else swing),
        -tracking_weight * tracking,
        -action_weight * action * action,
    )


@inlined
def _phases(mean: float, variance: float, target: float, tracking_swing: float) -> tuple[float, float]:
    """What shaking and being off the target cost in phases; both largest for a bit that stands.

    Being on target counts half at `tracking_swing`.
    """
    slow = _SLOW * target
    motion = min(1.0, abs(mean) / slow)
    swing = motion * min(sqrt(variance) / max(abs(mean), slow), _LARGEST_SWING) + (1.0 - motion) * _LARGEST_SWING
    error = motion * min(abs(mean - target) / target, _LARGEST_ERROR) + (1.0 - motion) * _LARGEST_ERROR
    calm = 1.0 / (1.0 + (swing / CALM_SWING) ** 2)
    counts = 1.0 / (1.0 + (swing / tracking_swing) ** 2)
    on_target = 1.0 / (1.0 + (error / _SMALL_ERROR) ** 2)
    return 1.0 - calm + swing / 2.0, 1.0 - counts * on_target + error / 10.0
