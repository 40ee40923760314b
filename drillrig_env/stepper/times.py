"""Sample times: how many fit into a duration, which times are the same, and into how many steps a period is cut."""

from __future__ import annotations

from functools import lru_cache
from math import ceil

import numpy as np

from drillrig_env.parameters import POSITIVE, refuse
from drillrig_env.rig import Rig
from drillrig_env.stepper.limits import check_computable
from drillrig_env.stepper.tables import LONGEST_PERIOD
from drillrig_env.stepper.units import units_of

_SAME = 1e-8
"""Times closer than this share of a sample period are the same time: 0.3 / 0.1 is below 3 by rounding alone."""

_FINEST = 8.0
"""Shortest sample period, in spacings of doubles at the last time."""

_MOST_PARTS = 1e12
"""Most steps that a period is cut into: more would take years."""


def sample_count(where: str, duration: float, sample_period: float) -> int:
    """How many whole sample periods a duration has (both s), one that is whole but for rounding counted.

    Raises `ValueError` for what is not positive, and for periods that doubles at that time do not resolve.
    """
    for name, value in (("duration", duration), ("sample_period", sample_period)):
        if not POSITIVE.holds(value):
            raise refuse(where, name, value, "s", POSITIVE)
    finest = _FINEST * float(np.spacing(duration))
    if sample_period < finest:
        raise refuse(where, "sample_period", sample_period, "s", f">= {finest:.2g}, as doubles at {duration:g} s need,")
    return int(np.floor(duration / sample_period + same_time(duration, sample_period) / sample_period))


def same_time(duration: float, sample_period: float) -> float:
    """How close two times (s) of a run must be to be the same."""
    return _SAME * sample_period + 2.0 * float(np.spacing(duration))


@lru_cache(maxsize=1024)
def step_of(rig: Rig, period: float) -> tuple[int, float]:
    """Into how many equal steps a period (s) is cut so that none is too long for the stepper, and their length.

    Raises `ValueError` for a rig that cannot be computed, and for a period of which no steps can be counted.
    """
    check_computable(rig)
    longest = _MOST_PARTS * LONGEST_PERIOD * units_of(rig).time
    if not period <= longest:
        raise refuse("simulate", "sample_period", period, "s", f"<= {longest:g}")
    parts = max(1, ceil(period / (LONGEST_PERIOD * units_of(rig).time) - _SAME / 100.0))
    return parts, period / parts
