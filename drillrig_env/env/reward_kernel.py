"""The reward in compiled code: running statistics of the bit speed, and the terms that come of them."""

from __future__ import annotations

from math import sqrt

from drillrig_env.jit.compiled import inlined


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
