"""What counts as stick-slip, as calm and as mitigated: the one definition that every score uses.

The stick-slip index of the bit speed over a window is SSI = (max - min) / (2 mean); 1 is full
stick-slip. The factor 2 is part of the definition.

>>> from drillrig_env.verdict import is_calm, is_mitigated, stick_slip_index
>>> is_calm(lowest=2.9, highest=3.1, mean=3.0), is_calm(lowest=0.0, highest=6.2, mean=3.0)
(True, False)
>>> round(float(stick_slip_index(lowest=0.0, highest=6.2, mean=3.0)), 3)
1.033
>>> bool(is_mitigated(2.9, 3.1, mean=3.0, target=3.1))
True
>>> bool(is_mitigated(2.9, 3.1, mean=3.0, target=3.5))  # calm, and too slow
False
"""

from __future__ import annotations

from typing import Any

import numpy as np

from drillrig_env.arrays import FloatArray, Quantity

CALM_INDEX = 0.1
"""Calm is a stick-slip index below this..."""

MOVING_INDEX = 0.5
"""Below this index the bit is certain not to stand still: where the lowest speed is 0 the highest is above the mean."""

LEAST_MEAN = 0.05
"""...at a mean bit speed (rad/s) above this: standing still is not calm. The chapter rig's, as all here."""

TRACKING_TOLERANCE = 0.05
"""Mitigated is calm, with the mean bit speed within this share of the target."""

WINDOW = 10.0
"""The end of an episode (s) over which calm and mitigated are judged."""

STUCK_SPEED = 0.01
"""The bit counts as stuck below this speed (rad/s)."""


def stick_slip_index(lowest: Quantity, highest: Quantity, mean: Quantity) -> FloatArray:
    """SSI of windows from their lowest, highest and mean bit speed (rad/s); infinite where the mean is not positive."""
    with np.errstate(divide="ignore", invalid="ignore"):
        index = (np.asarray(highest) - lowest) / (2.0 * np.asarray(mean))
    return np.where(np.asarray(mean) > 0.0, index, np.inf)


def is_calm(lowest: Any, highest: Any, mean: Any, speed_scale: float = 1.0, index: float = CALM_INDEX) -> Any:
    """Whether windows of bit speed are calm, SSI < `index`; numbers or arrays.

    `lowest`, `highest` and `mean` are those of the windows, rad/s.

    `speed_scale` is the rig's scale of speeds, see `drillrig_env.scales`.
    """
    return (highest - lowest < index * 2.0 * mean) & (mean > LEAST_MEAN * speed_scale)


def is_mitigated(
    lowest: Any, highest: Any, mean: Any, target: Any, speed_scale: float = 1.0, index: float = CALM_INDEX
) -> Any:
    """Whether windows are calm and their mean bit speed within 5 % of the target; numbers or arrays.

    `lowest`, `highest`, `mean` and `target` are in rad/s; `speed_scale` and `index` as for `is_calm`.
    """
    return is_calm(lowest, highest, mean, speed_scale, index) & (np.abs(mean - target) <= TRACKING_TOLERANCE * target)
