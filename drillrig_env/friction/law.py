"""The laws of friction in compiled code, for kernels; `Friction` is the same for everybody else.

It has a file of its own so that whoever only describes a friction loads no compiler.

A law is a torque by pieces, each smooth and continued smoothly beyond its zone: the straight line in the stick zone
(0), the fall with speed beyond it (1 forwards, -1 backwards), and under a linear fall the floor (2, -2).
"""

from __future__ import annotations

from math import exp, inf
from typing import Any

import numpy as np

from drillrig_env.arrays import FloatArray, Quantity, Record, Records
from drillrig_env.friction.contact import CONTACT, EXPONENTIAL, GAUSSIAN, LAWS, LINEAR
from drillrig_env.jit.compiled import compiled, inlined
from drillrig_env.jit.pointer import call
from drillrig_env.parameters import refuse
from drillrig_env.rig import Rig

_LOOKS = 24
"""Speeds at which a law of the user's own is looked at for its steepest fall, up to 1/v_b times 2^7."""

_GAUSSIAN_STEEPEST, _GAUSSIAN_BEND = 0.8577638849607068, 2.3316439815971242
"""Of exp(-a^2): the steepest slope, sqrt(2/e), and the strongest curvature as a multiple of it."""


@inlined
def press(
    contact: Record, normal_force: float, mu_s: float, mu_k: float, v_b: float, r_1: float, omega_s: float, law: int
) -> None:
    """Put a pin with a friction onto the disc: `normal_force` N_1 in N, `v_b` in s/rad, `r_1` in m, `omega_s` in rad/s.

    `law` is the number of a law, as in CONTACT.
    """
    contact.static = normal_force * r_1 * mu_s
    contact.kinetic = normal_force * r_1 * mu_k
    contact.v_b, contact.omega_s, contact.knee = v_b, omega_s, inf
    contact.load, contact.mu_s, contact.mu_k, contact.law = normal_force * r_1, mu_s, mu_k, law
    if law != EXPONENTIAL:
        _join(contact)


@compiled
def _join(contact: Record) -> None:
    """Let the straight line of any law but the chapter's lead to where its fall begins, without a jump."""
    if contact.law == LINEAR:
        contact.knee = 1.0 / contact.v_b
    zone = 2 if contact.omega_s >= contact.knee else 1
    contact.static, _, _ = _other_law(zone, contact.omega_s, contact)


def contacts_of(
    rig: Rig,
    normal_force: Quantity,
    mu_s: Quantity,
    mu_k: Quantity,
    v_b: Quantity,
    speed_reference: Quantity = 0.0,
    law: int = EXPONENTIAL,
) -> np.ndarray:
    """Records of CONTACT for rigs that share `rig`; shapes broadcast. Units as for `press`, rad/s for the last.

    Raises `ValueError` for a friction torque that no double holds.
    """
    values = (normal_force, mu_s, mu_k, v_b, rig.r_1, rig.omega_s, speed_reference)
    columns = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in values))
    contacts = np.zeros(columns[0].shape, dtype=CONTACT)
    press_over(contacts.reshape(-1), np.stack([column.ravel() for column in columns]), law)
    if not np.isfinite(contacts["static"]).all():
        largest = np.finfo(float).max / np.max(rig.r_1) / np.max(mu_s)
        raise refuse("Friction", "normal_force", float(np.max(normal_force)), "N", f"<= {largest:.3g}")
    return contacts


@compiled
def press_over(contacts: Records, table: FloatArray, law: int) -> None:
    """`press` for each of n `contacts`; `table` has rows for N_1, mu_s, mu_k, v_b, r_1, omega_s and omega_ref."""
    for i in range(contacts.shape[0]):
        press(contacts[i], table[0, i], table[1, i], table[2, i], table[3, i], table[4, i], table[5, i], law)
        contacts[i].speed_reference = table[6, i]


@inlined
def zone_of(x_3: float, omega_s: float, knee: float) -> int:
    """The piece of the law that holds at x_3: 0 stick, 1 slip forwards, -1 backwards, 2 and -2 beyond the `knee`."""
    if x_3 >= omega_s:
        return 2 if x_3 >= knee else 1
    if x_3 <= -omega_s:
        return -2 if x_3 <= -knee else -1
    return 0


@inlined
def edges_of(zone: int, omega_s: float, knee: float) -> tuple[float, float]:
    """Between which sizes of x_3 a piece holds; those of the stick zone are of both signs."""
    if zone == 0:
        return -omega_s, omega_s
    if zone * zone == 1:
        return omega_s, knee
    return max(knee, omega_s), inf


@inlined
def zone_beyond(zone: int, forwards: bool, at_knee: bool, is_flat: bool) -> int:
    """The piece that holds beyond the kink at which another ends; `is_flat` where the fall ends within the stick zone.

    `at_knee`: it is the kink where the fall meets the floor, and not the edge of the stick zone.
    """
    side = 1 if forwards else -1
    if at_knee and not is_flat:
        return side if zone * zone > 1 else 2 * side
    if zone != 0:
        return 0
    return 2 * side if is_flat else side


@inlined
def torque_in_zone(zone: int, x_3: float, contact: Record) -> tuple[float, float]:
    """Torque and slope of one piece of a law for a `Contact` or a record of it, continued smoothly beyond its zone.

    The smooth continuation lets an integrator reach past the kink and then say where it was crossed.
    """
    if zone == 0:
        slope = contact.static / contact.omega_s
        return slope * x_3, slope
    if contact.law != EXPONENTIAL:
        torque, slope, _ = _other_law(zone, x_3, contact)
        return torque, slope
    decaying = (contact.static - contact.kinetic) * exp(-contact.v_b * zone * x_3)
    return zone * (contact.kinetic + decaying), -contact.v_b * decaying


@compiled
def _other_law(zone: int, x_3: float, contact: Record) -> tuple[float, float, float]:
    """Torque, slope and curvature of a slipping piece of any law but the exponential one."""
    side = 1.0 if zone > 0 else -1.0
    a, load, v_b = side * x_3, contact.load, contact.v_b
    fall = load * (contact.mu_s - contact.mu_k)
    if contact.law == LINEAR:
        if zone * zone > 1:
            return side * contact.kinetic, 0.0, 0.0
        return side * (load * contact.mu_s - fall * v_b * a), -fall * v_b, 0.0
    if contact.law == GAUSSIAN:
        u = v_b * a
        decaying = fall * exp(-u * u)
        bend = side * decaying * v_b * v_b * (4.0 * u * u - 2.0)
        return side * (contact.kinetic + decaying), -2.0 * v_b * u * decaying, bend
    # A law of the user's own is asked for no speed within the stick zone, where it goes on as a parabola.
    inside = min(a - contact.omega_s, 0.0)
    mu, slope, bend = call(contact.law, max(a, contact.omega_s), contact.mu_s, contact.mu_k, v_b)
    mu += inside * (slope + 0.5 * inside * bend)
    slope += inside * bend
    return side * load * mu, load * slope, side * load * bend


@compiled
def steepest_of(contact: Record) -> tuple[float, float]:
    """How steeply any law but the exponential one falls (N m s/rad), and how fast its slope changes (s/rad)."""
    fall = contact.load * (contact.mu_s - contact.mu_k)
    if contact.law == LINEAR:
        return fall * contact.v_b, 0.0
    if contact.law == GAUSSIAN:
        return _GAUSSIAN_STEEPEST * fall * contact.v_b, _GAUSSIAN_BEND * contact.v_b
    steepest, largest, strongest, a = 0.0, 0.0, 0.0, 2.0**-5 / contact.v_b
    for _ in range(_LOOKS):
        _, slope, bend = _other_law(1, a, contact)
        steepest, largest, strongest = max(steepest, -slope), max(largest, abs(slope)), max(strongest, abs(bend))
        a *= 2.0**0.5
    return steepest, (strongest / largest if largest > 0.0 else 0.0)


@compiled
def _steepest_over(contacts: Records, steepest: FloatArray) -> None:
    for i in range(contacts.shape[0]):
        steepest[i], _ = steepest_of(contacts[i])


def steepest_over(contacts: np.ndarray) -> FloatArray:
    """How steeply friction falls (N m s/rad) by `contacts` of any law but the exponential one; both of shape (n,)."""
    steepest = np.empty(contacts.shape)
    _steepest_over(contacts, steepest)
    return steepest


@compiled
def law_over(x_3: FloatArray, contacts: Records, torque: FloatArray, slope: FloatArray, curvature: FloatArray) -> None:
    """Torque, slope and curvature at bit speeds `x_3` with one of the `contacts` each, into arrays of shape (n,)."""
    for i in range(x_3.size):
        contact = contacts[i]
        zone = zone_of(x_3[i], contact.omega_s, contact.knee)
        torque[i], slope[i] = torque_in_zone(zone, x_3[i], contact)
        if zone == 0:
            curvature[i] = 0.0
        elif contact.law == EXPONENTIAL:
            curvature[i] = -contact.v_b * (slope[i] if zone > 0 else -slope[i])
        else:
            _, _, curvature[i] = _other_law(zone, x_3[i], contact)


def number_of(law: Any) -> int:
    """The number of a law for the field `law` of a contact, from its name or from a law of the user's own."""
    if isinstance(law, str):
        return LAWS.index(law)
    from drillrig_env.friction.own import address_of

    return address_of(law)
