"""Actions: what is taken as one, and which one leads to a wanted speed reference."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.scales import CONTROL_PERIOD


def check_actions(actions: npt.NDArray[np.float32], rigs: int) -> npt.NDArray[np.float32]:
    """Actions as float32 of shape (rigs, 1). `ValueError` for another shape, no numbers and NaN, with its rig."""
    given = np.asarray(actions)
    if given.shape != (rigs, 1):
        raise ValueError(f"actions of shape {given.shape} are not allowed; allowed: shape ({rigs}, 1), -1 to 1")
    if given.dtype.kind not in "fiu":
        raise ValueError(f"actions of {given.dtype} are not allowed; allowed: numbers from -1 to 1")
    rates = np.ascontiguousarray(given, dtype=np.float32)
    bad = np.isnan(rates)
    if bad.any():
        raise ValueError(f"action = nan for rig {int(np.argmax(bad))} is not allowed; allowed: a number from -1 to 1")
    return rates


def rate_action(
    wanted: FloatArray, reference: FloatArray, slew_limit: float, control_period: float = CONTROL_PERIOD
) -> npt.NDArray[np.float32]:
    """The action, -1 to 1, that takes the speed reference towards a wanted one (rad/s) within a control step; (n, 1).

    `wanted` and `reference` have shape (n,); `slew_limit` is in rad/s^2, `control_period` in s.
    """
    rate = (wanted - reference) / (slew_limit * control_period)
    return np.asarray(np.clip(rate, -1.0, 1.0), dtype=np.float32)[:, None]
