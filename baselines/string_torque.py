"""The torque into the string as a controller at the top sees it: less its slow mean, from whatever is shown.

Torque laws answer the deviation of T_s = -(k_2 x_2 + d_2 (x_4 - x_5)) from its slow mean LP(T_s). A
high-pass needs differences only: where the low-pass follows with the gain g a step,

    deviation <- (1 - g) (deviation + change of T_s since the last step).

So the twist need not be seen: two encoders give its change, the integral of x_4 - x_5 over the step.

A resonator at the string's lowest mode makes an oscillation of it, with amplitude and phase: noise goes,
and what is known late can be turned on in time.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, pi, sin

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.parameters import POSITIVE, Allowed, refuse
from drillrig_env.rig import Rig
from drillrig_env.scales import CONTROL_PERIOD

TORQUE_SHOWN: tuple[tuple[str, ...], ...] = (
    ("twist_23", "collar_speed", "top_speed"),
    ("string_torque",),
    ("collar_speed", "top_speed"),
)
"""Channels that give the deviation, the most exact first; for a policy's `any_of`."""

MEMORY = 3
"""Columns of memory that `torque_deviation` keeps: samples seen, deviation, last torque (or last x_4 - x_5)."""


def torque_from_twist(rig: Rig, seen: Mapping[str, FloatArray]) -> FloatArray:
    """T_s = -(k_2 x_2 + d_2 (x_4 - x_5)), N m, shape (n,), from the upper twist and the speeds at its ends."""
    return -(rig.k_2 * seen["twist_23"] + rig.d_2 * (seen["collar_speed"] - seen["top_speed"]))


def torque_deviation(
    rig: Rig,
    seen: Mapping[str, FloatArray],
    memory: FloatArray,
    time_constant: float,
    period: float = CONTROL_PERIOD,
) -> FloatArray:
    """Deviation of the torque into the string from its slow mean, N m, shape (n,).

    `seen` holds physical values by name and shows one of TORQUE_SHOWN; `memory` of shape (n, MEMORY),
    zero when an episode begins, is changed in place. The mean is that of all samples while fewer than
    `time_constant` (s) is past, and a first-order low-pass from then on, each `period` (s). From speeds alone the
    change of the twist is a trapezoid over the step, 2 % small for the string's lower mode and 11 % for its upper.
    """
    samples, last = memory[:, 0], memory[:, 2].copy()
    damping: FloatArray | float = 0.0
    if "twist_23" in seen and "collar_speed" in seen:
        torque = torque_from_twist(rig, seen)
        change = torque - last
        memory[:, 2] = torque
    elif "string_torque" in seen:
        change = seen["string_torque"] - last
        memory[:, 2] = seen["string_torque"]
    else:
        twist_rate = seen["collar_speed"] - seen["top_speed"]
        change = -rig.k_2 * 0.5 * (twist_rate + last) * period
        damping = -rig.d_2 * twist_rate  # its mean is zero: no filter
        memory[:, 2] = twist_rate
    gain = np.maximum(1.0 / (samples + 1.0), period / time_constant)
    memory[:, 1] = (1.0 - gain) * (memory[:, 1] + change)
    memory[:, 0] = samples + 1.0
    return np.asarray(memory[:, 1] + damping)


OSCILLATION_MEMORY = 2
"""Columns of memory that `oscillation` keeps: its real and its imaginary part."""


def oscillation(
    rig: Rig, deviation: FloatArray, memory: FloatArray, follow: float, period: float = CONTROL_PERIOD
) -> FloatArray:
    """The deviation (N m) as a complex oscillation z at the string's lowest mode of w rad/s, shape (n,).

    z <- u + `follow` (deviation - Re u) with u = e^(i w dt) z: the modulus is the amplitude, the angle the
    phase. `follow` 1 takes the deviation as it is; less takes out noise and what is far from the mode.
    `memory` of shape (n, OSCILLATION_MEMORY), zero when an episode begins, is changed in place.
    """
    step = 2.0 * pi * rig.string_frequencies[0] * period
    real, imaginary = memory[:, 0].copy(), memory[:, 1].copy()
    expected = cos(step) * real - sin(step) * imaginary
    memory[:, 0] = expected + follow * (deviation - expected)
    memory[:, 1] = sin(step) * real + cos(step) * imaginary
    return np.asarray(memory[:, 0] + 1j * memory[:, 1])


def check_filters(where: str, time_constant: float, follow: float) -> None:
    """Raise `ValueError` for a `time_constant` (s) or a `follow` that the filters here cannot work with."""
    if not POSITIVE.holds(time_constant):
        raise refuse(where, "time_constant", time_constant, "s", POSITIVE)
    shares = Allowed(low=0.0, high=1.0, low_open=True)
    if not shares.holds(follow):
        raise refuse(where, "follow", follow, "", shares)
