"""Rigs that no environment is made of: those whose drive runs away, whatever a controller asks of it.

Where steady rotation is unstable even without friction, the speed loop drives its own oscillation on until no number
holds it. `simulate` takes such a rig, to show it.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from drillrig_env.drive import Drive
from drillrig_env.model import jacobian
from drillrig_env.rig import Rig
from drillrig_env.stepper.limits import with_lag

_CLEAR = 1e-12
"""Beside the largest eigenvalue: how far from the imaginary axis rounding leaves no doubt on which side one lies."""

_SMALLEST = 2.0**-40
"""Of the integral gain: what is tried before a rig is said to run away with any."""


@lru_cache(maxsize=256)
def check_steady(rig: Rig, drive: Drive | None = None) -> None:
    """Raise `ValueError`, with gains that would do, for a rig whose drive runs away even without friction.

    `drive` takes the place of the rig's own.
    """
    own = drive or Drive.of_rig(rig)
    driven = replace(rig, k_p=own.k_p, k_i=own.k_i, K_E=own.remaining_K_E(rig))
    if _is_steady(driven):
        return
    k_i = _slow_enough(driven)
    remedy = f", such as k_i = {k_i:.3g} V/rad" if k_i else ", which needs damping in the string or the motor"
    raise ValueError(
        f"DrillRig: k_p = {own.k_p:g} V s/rad with k_i = {own.k_i:g} V/rad lets the drive of this rig run away: steady "
        f"rotation is unstable even without friction; allowed: a drive and a rig with which it is stable{remedy}"
    )


def _is_steady(rig: Rig) -> bool:
    """Whether steady rotation without friction is stable; by Routh's scheme without rounding where that is close."""
    rig = with_lag(rig)
    with np.errstate(all="ignore"):
        found = np.linalg.eigvals(jacobian(rig))
    if found.real.max() < -_CLEAR * np.abs(found).max():
        return True
    from drillrig_env.stability.stable_sets import is_bearable  # half a second, for what few rigs need

    return is_bearable(rig, 0.0)


def _slow_enough(rig: Rig) -> float:
    """An integral gain (V/rad) with which the rig turns steadily, half of its own or less; 0 where there is none.

    All else in a rig takes power from what swings, or gives it none, so that it is the integral that is too fast.
    """
    share = 0.5
    while share >= _SMALLEST:
        if _is_steady(replace(rig, k_i=share * rig.k_i)):
            return share * rig.k_i
        share /= 2.0
    return 0.0
