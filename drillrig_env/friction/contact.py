"""The contact of pin and disc as the kernels take it: one record a rig, all that is held over a period.

`Friction.contacts` makes the records, the stepper reads them field by field. `Contact` is the same with plain
numbers, for Python code that evaluates the law time and again.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

EXPONENTIAL, GAUSSIAN, LINEAR = 0, 1, 2
"""Laws that the kernels know, as the field `law`; any other number is the address of a law in machine code."""

LAWS = ("exponential", "gaussian", "linear")
"""Their names, in this order."""


class Contact(NamedTuple):
    """The contact of one rig: what its friction torque depends on besides the bit speed, and its speed reference."""

    static: float  # torque at omega_s that the straight line of (4-9) leads up to, N m
    kinetic: float  # N_1 r_1 mu_k, N m
    v_b: float  # s/rad
    omega_s: float  # rad/s
    speed_reference: float  # omega_ref, rad/s
    knee: float = inf  # rad/s, where a linear fall meets its floor
    load: float = 0.0  # N_1 r_1, N m
    mu_s: float = 0.0
    mu_k: float = 0.0
    law: int = EXPONENTIAL
    tilt: float = 0.0  # share by which N_1 varies with the angle theta_1
    turns: float = 1.0  # how often as disc 1 turns once
    angle: float = 0.0  # turns * theta_1 + phi at the start of the period, less turns * (y_1 + y_2 - y_7) there, rad
    period: float = 0.0  # s; only where there is a tilt


CONTACT = np.dtype([(name, "i8" if name == "law" else "f8") for name in Contact._fields], align=True)
"""`Contact` as a record."""
