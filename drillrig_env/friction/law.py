"""The law (4-9) in compiled code, for kernels; `Friction` is the same for everybody else.

It has a file of its own so that whoever only describes a friction loads no compiler.
"""

from __future__ import annotations

from math import exp

import numpy as np

from drillrig_env.arrays import FloatArray, Quantity, Record, Records
from drillrig_env.friction.contact import CONTACT
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.parameters import refuse
from drillrig_env.rig import Rig


@inlined
def press(contact: Record, normal_force: float, mu_s: float, mu_k: float, v_b: float, r_1: float) -> None:
    """Put a pin with a friction onto the disc: `normal_force` N_1 in N, `v_b` in s/rad, `r_1` in m."""
    contact.static = normal_force * r_1 * mu_s
    contact.kinetic = normal_force * r_1 * mu_k
    contact.v_b = v_b


def contacts_of(
    rig: Rig, normal_force: Quantity, mu_s: Quantity, mu_k: Quantity, v_b: Quantity, speed_reference: Quantity = 0.0
) -> np.ndarray:
    """Records of CONTACT for rigs that share `rig`; shapes broadcast. Units as for `press`, rad/s for the last.

    Raises `ValueError` for a friction torque that no double holds.
    """
    shape = np.broadcast_shapes(*(np.shape(value) for value in (normal_force, mu_s, mu_k, v_b, speed_reference)))
    contacts = np.empty(shape, dtype=CONTACT)
    fields = contacts.view(np.recarray)
    with np.errstate(over="ignore", invalid="ignore"):
        press.py_func(fields, np.asarray(normal_force), mu_s, mu_k, v_b, rig.r_1)  # type: ignore[attr-defined]
        if not np.isfinite(fields.static).all():
            largest = np.finfo(float).max / rig.r_1 / np.max(mu_s)
            raise refuse("Friction", "normal_force", float(np.max(normal_force)), "N", f"<= {largest:.3g}")
    fields.omega_s, fields.speed_reference = rig.omega_s, speed_reference
    return contacts


@inlined
def zone_of(x_3: float, omega_s: float) -> int:
    """The piece of (4-9) that holds at x_3: 0 stick, 1 slip forwards, -1 slip backwards."""
    if x_3 >= omega_s:
        return 1
    if x_3 <= -omega_s:
        return -1
    return 0


@inlined
def torque_in_zone(zone: int, x_3: float, contact: Record) -> tuple[float, float]:
    """Torque and slope of one piece of (4-9) for a `Contact` or a record of it, continued smoothly beyond its zone.

    The smooth continuation lets an integrator reach past the kink and then say where it was crossed.
    """
    if zone == 0:
        slope = contact.static / contact.omega_s
        return slope * x_3, slope
    decaying = (contact.static - contact.kinetic) * exp(-contact.v_b * zone * x_3)
    return zone * (contact.kinetic + decaying), -contact.v_b * decaying


@compiled
def law_over(x_3: FloatArray, contacts: Records, torque: FloatArray, slope: FloatArray) -> None:
    """Torque and slope of (4-9) at bit speeds `x_3` with one of the `contacts` each, into arrays; all of shape (n,)."""
    for i in range(x_3.size):
        contact = contacts[i]
        torque[i], slope[i] = torque_in_zone(zone_of(x_3[i], contact.omega_s), x_3[i], contact)
