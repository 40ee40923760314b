"""The case that solvers are compared on: the chapter's rig in stick-slip, and its equations as the peers get them.

There is one right-hand side for peers that take machine code (`compiled_rates`, with its Jacobian) and one for
peers that compute with arrays of their own kind (`array_rates`, which are `model.state_equations` themselves).
Both take what tells one rig from the next as four numbers, a *contact*: N_1 r_1 mu_s and N_1 r_1 mu_k (N m),
v_b (s/rad) and the speed reference (rad/s).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numba
import numpy as np

from drillrig_env import Friction, Rig
from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.friction import Contact
from drillrig_env.friction.law import torque_in_zone, zone_of
from drillrig_env.model import friction_input, jacobian, state_equations
from drillrig_env.reference import radau

RIG = Rig()
START = np.array([0.0, 0.0, 2.0, 2.0, 2.0, 0.5, 0.0])
SAMPLE_PERIOD = 0.1  # s
NORMAL_FORCES, SPEED_REFERENCES = (5.0, 40.0), (0.5, 5.0)  # N and rad/s, the ranges of a batch

Rates: TypeAlias = Callable[[FloatArray, FloatArray, FloatArray], None]
"""`rates(x, contact, out)` writes the 7 rates, or the (7, 7) Jacobian, at the states x into out."""


@dataclass(frozen=True, eq=False)
class Rigs:
    """One rig, or many: normal force (N) and speed reference (rad/s) of each, shape (rigs,)."""

    normal_force: FloatArray
    speed_reference: FloatArray

    def __len__(self) -> int:
        return len(self.normal_force)

    @property
    def friction(self) -> Friction:
        """The friction of all rigs."""
        return Friction(self.normal_force)

    @property
    def contacts(self) -> FloatArray:
        """The contact of each rig, shape (rigs, 4)."""
        records = self.friction.contacts(RIG, self.speed_reference, len(self))
        return np.stack([records[name] for name in ("static", "kinetic", "v_b", "speed_reference")], axis=1)

    def bit_speeds(self, times: FloatArray, rtol: float = 1e-11) -> FloatArray:
        """Bit speed at `times[1:]` by Radau with the kinks split by events, shape (rigs, len(times) - 1)."""
        return np.stack(
            [
                radau(RIG, Friction(force), speed, START, times, rtol=rtol, atol=1e-2 * rtol)[:, 2]
                for force, speed in zip(self.normal_force.tolist(), self.speed_reference.tolist(), strict=True)
            ]
        )


ONE_RIG = Rigs(np.array([20.0]), np.array([2.0]))
"""Stick-slip from the first second on."""


def drawn_rigs(rigs: int) -> Rigs:
    """Rigs at 5 to 40 N and 0.5 to 5 rad/s, the same in every run; a larger batch begins with the smaller one's."""
    lowest, highest = zip(NORMAL_FORCES, SPEED_REFERENCES, strict=True)
    normal_force, speed_reference = np.random.default_rng(0).uniform(lowest, highest, (rigs, 2)).T.copy()
    return Rigs(normal_force, speed_reference)


def sample_times(duration: float) -> FloatArray:
    """Times every 0.1 s from 0 to `duration`, s."""
    return SAMPLE_PERIOD * np.arange(round(duration / SAMPLE_PERIOD) + 1, dtype=np.float64)


def compiled_rates() -> Rates:
    """A new copy of (4-17) with (4-9), for Numba to compile when it is first called.

    The coefficients are those of `model`, so that no product is left that could be made beforehand.
    """
    A, to_rates, omega_s = jacobian(RIG), friction_input(RIG), RIG.omega_s
    offset = np.array(state_equations([0.0] * 7, 0.0, 0.0, RIG))
    from_reference = np.array(state_equations([0.0] * 7, 1.0, 0.0, RIG)) - offset

    @numba.njit(nogil=True, error_model="numpy")
    def rates(x: FloatArray, contact: FloatArray, out: FloatArray) -> None:
        omega_ref = contact[3]
        pressed = Contact(contact[0], contact[1], contact[2], omega_s, omega_ref, np.inf, 0.0, 0.0, 0.0, 0)
        torque, _ = torque_in_zone(zone_of(x[2], omega_s, pressed.knee), x[2], pressed)
        out[0] = x[2] - x[3]
        out[1] = x[3] - x[4]
        out[2] = A[2, 0] * x[0] + A[2, 2] * x[2] + A[2, 3] * x[3] + to_rates[2] * torque
        out[3] = A[3, 0] * x[0] + A[3, 1] * x[1] + A[3, 2] * x[2] + A[3, 3] * x[3] + A[3, 4] * x[4] + offset[3]
        out[4] = A[4, 1] * x[1] + A[4, 3] * x[3] + A[4, 4] * x[4] + A[4, 5] * x[5] + offset[4]
        out[5] = A[5, 4] * x[4] + A[5, 5] * x[5] + A[5, 6] * x[6] + from_reference[5] * omega_ref
        out[6] = omega_ref - x[4]

    return rates  # type: ignore[no-any-return,unused-ignore]


def compiled_jacobian() -> Rates:
    """A new copy of the Jacobian (4-19) with the slope of (4-9), for Numba to compile."""
    A, to_rates, omega_s = jacobian(RIG), friction_input(RIG), RIG.omega_s

    @numba.njit(nogil=True, error_model="numpy")
    def slopes(x: FloatArray, contact: FloatArray, out: FloatArray) -> None:
        pressed = Contact(contact[0], contact[1], contact[2], omega_s, contact[3], np.inf, 0.0, 0.0, 0.0, 0)
        _, slope = torque_in_zone(zone_of(x[2], omega_s, pressed.knee), x[2], pressed)
        out[:] = A
        out[2, 2] += to_rates[2] * slope

    return slopes  # type: ignore[no-any-return,unused-ignore]


def slip_torque(exp: Callable[[Any], Any], direction: Any, x_3: Any, contact: Sequence[Any]) -> Any:
    """Torque of (4-9) while the bit slips in `direction` (1 or -1), in any arithmetic that has `exp`, N m."""
    static, kinetic, v_b, _ = contact
    return direction * (kinetic + (static - kinetic) * exp(-v_b * direction * x_3))


def stick_torque(x_3: Any, contact: Sequence[Any]) -> Any:
    """Torque of (4-9) in the stick zone, N m."""
    return contact[0] / RIG.omega_s * x_3


def array_rates(library: Any, x: Sequence[Any], contact: Sequence[Any]) -> list[Any]:
    """(4-17) with (4-9) in the arithmetic of `library`, such as `numpy`, `jax.numpy` or `torch`.

    `x` has the 7 states and `contact` its 4 numbers as entries: scalars, or arrays with an entry a rig.
    """
    x_3 = x[2]
    slip = slip_torque(library.exp, library.sign(x_3), x_3, contact)
    torque = library.where(library.abs(x_3) < RIG.omega_s, stick_torque(x_3, contact), slip)
    return state_equations(x, contact[3], torque, RIG)


def largest_errors(states: FloatArray, bit_speeds: FloatArray) -> Quantity:
    """Largest error of the bit speed of each rig, rad/s.

    `states` (..., samples, 7) begin with the start, `bit_speeds` (..., samples - 1) after it; the shorter one counts.
    """
    found = states[..., 1:, 2]
    samples = min(found.shape[-1], bit_speeds.shape[-1])
    errors = np.abs(found[..., :samples] - bit_speeds[..., :samples])
    return np.asarray(np.max(np.where(np.isfinite(errors), errors, np.inf), axis=-1))
