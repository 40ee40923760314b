"""The contact of pin and disc as the kernels take it: one record a rig, all that is held over a period.

`Friction.contacts` makes the records, the stepper reads them field by field. `Contact` is the same with plain
numbers, for Python code that evaluates the law time and again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Contact(NamedTuple):
    """The contact of one rig: what its friction torque depends on besides the bit speed, and its speed reference."""

    static: float  # N_1 r_1 mu_s, N m
    kinetic: float  # N_1 r_1 mu_k, N m
    v_b: float  # s/rad
    omega_s: float  # rad/s
    speed_reference: float  # omega_ref, rad/s


CONTACT = np.dtype([(name, "f8") for name in Contact._fields], align=True)
"""`Contact` as a record."""
