"""The slowest torsional mode of a rig, with the top held still: how long it takes, and how it is damped.

In closed form, so that it scales with the rig to the last bit where its parameters do by powers of two.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf, log, pi, sqrt

from drillrig_env.allowed import Allowed
from drillrig_env.rig import Rig

_PERIODS = Allowed(1e-9, 1e9)  # s


@lru_cache(maxsize=64)
def slowest_period(rig: Rig) -> float:
    """Period (s) of the mode, without damping. Raises `ValueError` for one that is beyond what can be computed."""
    try:
        period = 2.0 * pi / sqrt(_slowest(rig))
    except ArithmeticError:  # J and k are further apart than numbers reach
        period = inf
    if not _PERIODS.holds(period):
        name = max(("J_1", "J_2", "k_1", "k_2"), key=lambda one: abs(log(getattr(rig, one)) - log(getattr(Rig(), one))))
        value, unit = getattr(rig, name), Rig.__dataclass_fields__[name].metadata["unit"]
        raise ValueError(
            f"Rig: {name} = {value:g} {unit} is beyond what can be computed; allowed: a value with which the slowest "
            f"period of the string is {_PERIODS} s"
        )
    return period


@lru_cache(maxsize=64)
def slowest_damping(rig: Rig) -> float:
    """Damping (N m s/rad) of the mode, as a damper on disc 1 that takes as much power."""
    twist = rig.J_1 * _slowest(rig) / rig.k_1  # of the lower shaft, where disc 1 turns by 1
    return rig.d_1 * twist**2 + rig.d_2 * (1.0 - twist) ** 2 + (rig.C_1 + rig.C_2 * (1.0 - twist) ** 2)


def _slowest(rig: Rig) -> float:
    """Square of the mode's angular frequency, 1/s^2."""
    bit, collars = rig.k_1 / rig.J_1, (rig.k_1 + rig.k_2) / rig.J_2
    spread = sqrt((collars - bit) ** 2 + 4.0 * (rig.k_1 / rig.J_1) * (rig.k_1 / rig.J_2))
    return 2.0 * (rig.k_1 / rig.J_1) * (rig.k_2 / rig.J_2) / (bit + collars + spread)
