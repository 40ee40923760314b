"""The contact of pin and disc as the kernels take it: one record a rig, all that is held over a period.

`drillrig_env.friction` makes the records, the stepper reads them field by field. `Contact` is the same with plain
numbers, for Python code that evaluates the law time and again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drillrig_env.arrays import Quantity, Record
from drillrig_env.jit.compiled import inlined
from drillrig_env.rig import Rig


class Contact(NamedTuple):
    """The contact of one rig: what its friction torque depends on besides the bit speed, and its speed reference."""

    static: float  # N_1 r_1 mu_s, N m
    kinetic: float  # N_1 r_1 mu_k, N m
    v_b: float  # s/rad
    omega_s: float  # rad/s
    speed_reference: float  # omega_ref, rad/s


CONTACT = np.dtype([(name, "f8") for name in Contact._fields], align=True)
"""`Contact` as a record."""


@inlined
def press(contact: Record, normal_force: float, mu_s: float, mu_k: float, v_b: float, r_1: float) -> None:
    """Put a pin with a friction onto the disc: `normal_force` N_1 in N, `v_b` in s/rad, `r_1` in m."""
    contact.static = normal_force * r_1 * mu_s
    contact.kinetic = normal_force * r_1 * mu_k
    contact.v_b = v_b


def contacts_of(
    rig: Rig, normal_force: Quantity, mu_s: Quantity, mu_k: Quantity, v_b: Quantity, speed_reference: Quantity = 0.0
) -> np.ndarray:
    """Records of CONTACT for rigs that share `rig`; shapes broadcast. Units as for `press`, rad/s for the last."""
    shape = np.broadcast_shapes(*(np.shape(value) for value in (normal_force, mu_s, mu_k, v_b, speed_reference)))
    contacts = np.empty(shape, dtype=CONTACT)
    fields = contacts.view(np.recarray)
    press.py_func(fields, np.asarray(normal_force), mu_s, mu_k, v_b, rig.r_1)  # type: ignore[attr-defined]
    fields.omega_s, fields.speed_reference = rig.omega_s, speed_reference
    return contacts
