"""Units of a rig's own: its time, its torque and its current, as powers of two of the chapter's.

Everything that the stepper calls small is a number in these units, so that a rig whose time runs faster, or whose
torques are larger, is stepped just as the chapter's: bit for bit where they differ by a power of two, since nothing
but exponents of the numbers differ then.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import frexp, sqrt

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.rig import Rig


@dataclass(frozen=True)
class Units:
    """What 1 s, 1 N m and 1 A are to the chapter's rig, for another one."""

    time: float  # s
    torque: float  # N m
    current: float  # A

    @property
    def speed(self) -> float:
        """The unit of all speeds, rad/s."""
        return 1.0 / self.time

    @property
    def states(self) -> FloatArray:
        """The units of the 7 states; shape (7,)."""
        return np.array([1.0, 1.0, self.speed, self.speed, self.speed, self.current, 1.0])


def units_of(rig: Rig) -> Units:
    """The units of a rig.

    Time goes by the period of the string with its top held still, as the sum of its squared periods gives it:
    J_1 / k_1 + (J_1 + J_2) / k_2; torque by J_1 / time^2, and current by torque / (eta K_T).
    """
    time, chapters = time_of(rig), time_of(_CHAPTER)
    torque = _power_of_two(rig.J_1 / time**2, _CHAPTER.J_1 / chapters**2)
    per_ampere = _power_of_two(rig.eta * rig.K_T, _CHAPTER.eta * _CHAPTER.K_T)
    return Units(_power_of_two(time, chapters), torque, torque / per_ampere)


_CHAPTER = Rig()


def time_of(rig: Rig) -> float:
    """Sum of the string's squared periods over (2 pi)^2, its root, in s; infinite where it overflows."""
    return sqrt(rig.J_1 / rig.k_1 + (rig.J_1 + rig.J_2) / rig.k_2)


def _power_of_two(value: float, chapters: float) -> float:
    """The power of two next to value / chapters on a scale of logarithms."""
    mantissa, exponent = frexp(value / chapters)
    return float(2.0 ** (exponent if mantissa >= sqrt(0.5) else exponent - 1))
