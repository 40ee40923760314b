"""Tables of the fast exact stepper: exponential collocation on a ladder of halved steps.

The model (4-17) is linear but for one scalar, the friction torque T_r1(x_3), and its input is
constant while omega_ref is held. With y = x - x_e, where x_e is the frictionless equilibrium at
omega_ref, variation of constants is exact:

    y(t + h) = exp(M h) y(t) + integral over s from 0 to h of exp(M (h - s)) b T_r1(x_3(t + s)) ds.

T_r1 over a step is the polynomial through its values at four Radau nodes. Every integral is then a
constant table, computed once for a rig and a step length from augmented matrix exponentials, and
the stiff motor costs nothing. `drillrig_env.stepper.collocation` solves a step, `drillrig_env.stepper.kinks` leads it
across the kinks of the friction law, and `drillrig_env.stepper.propagator` chooses the steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import factorial

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import expm

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.drive import Drive
from drillrig_env.jit.compiled import inlined
from drillrig_env.model import friction_input, frictionless_state, jacobian, torque_into_string
from drillrig_env.parameters import refuse
from drillrig_env.rig import Rig

NODES = 4
RUNGS = 18
UNITS = 1 << (RUNGS - 1)
"""Length of a period in units of the finest step; the rung r has steps of UNITS >> r units."""

SAMPLES = 16
"""Samples of bit speed and string torque taken inside a period, at equal distances."""

LONGEST_PERIOD = 0.1
"""Longest period (s) that the tolerances were established for."""

TOLERANCE = 1e-6
"""What the error of any speed (rad/s) stays below over 20 s, unless another tolerance is asked for."""

_TOLERANCES = (1e-7, 1e-3)

SAMPLED_RUNGS = 4
"""The longest steps, of the rungs below this one, span several samples and have tables for them."""

STATE = 8
"""The 7 states and a pad, so that a row fills whole vector registers."""


def _radau_nodes(count: int) -> FloatArray:
    """The right Radau nodes on (0, 1], the last one being 1: roots of P_n - P_(n-1)."""
    roots = np.sort(legendre.legroots([0.0] * (count - 1) + [-1.0, 1.0]).real)
    roots[-1] = 1.0
    return np.asarray((roots + 1.0) / 2.0)


RADAU_NODES = _radau_nodes(NODES)
POWERS_FROM_NODES = np.linalg.inv(np.vander(RADAU_NODES, increasing=True))
"""Coefficients of 1, s, s^2, s^3 of the cubic through the node values, over a step of length 1."""

RUNG = np.dtype(
    [
        ("node_from_state", "f8", (7, NODES)),
        ("node_from_torque", "f8", (NODES, NODES)),
        ("state_from_state", "f8", (7, STATE)),
        ("state_from_torque", "f8", (NODES, STATE)),
        ("rate_from_state", "f8", (7, STATE)),
        ("rate_from_torque", "f8", STATE),
        ("largest_defect", "f8"),  # N m, of a step that is taken
        ("newton_tolerance", "f8"),  # N m
        ("fine", "b1"),  # whether steps lead across kinks, so that their place must be exact
    ],
    align=True,
)
"""Tables of one step length. A rate is a change a step, so that time runs from 0 to 1 within one."""

SAMPLING = np.dtype(
    [
        ("speed_from_state", "f8", (7, SAMPLES)),
        ("speed_from_torque", "f8", (NODES, SAMPLES)),
        ("torque_from_state", "f8", (7, SAMPLES)),
        ("torque_from_torque", "f8", (NODES, SAMPLES)),
        ("torque_row", "f8", 7),
        ("torque_at_rest", "f8"),  # N m, of the equilibrium from which states are counted
    ],
    align=True,
)
"""Tables of the samples within one step: bit speed and torque into the string, from the states less the equilibrium."""


SHIFT = np.dtype([("at_rest", "f8", STATE), ("per_speed", "f8", STATE)], align=True)
"""The frictionless equilibrium: at the speed reference 0, and what 1 rad/s adds to it."""


@dataclass(frozen=True, eq=False)
class Tables:
    """The tables of one rig for one period of held speed reference, and how accurately to use them.

    `rungs` and `sampling` hold the tables, a record a rung; `shift` has one record, of the equilibrium
    from which the stepper counts the states (`from_equilibrium`, `to_states`).
    """

    rig: Rig
    drive: Drive | None
    period: float
    rungs: np.ndarray
    sampling: np.ndarray
    shift: np.ndarray


@lru_cache(maxsize=64)
@np.errstate(over="ignore", invalid="ignore")  # an impossible rig is found out by its first states
def step_tables(rig: Rig, period: float, tolerance: float = TOLERANCE, drive: Drive | None = None) -> Tables:
    """Build (or recall) the tables for a rig and a period in s; 0 < period <= LONGEST_PERIOD.

    `tolerance` (rad/s) is what the error of any speed stays below over 20 s: 1e-7 to 1e-3. The bounds on
    a step's errors that keep it there were found by trial, with a margin of 2 or more (see the tests).
    `drive` takes the place of the rig's own.
    Raises `ValueError` for a value that is not allowed.
    """
    low, high = _TOLERANCES
    if not low <= tolerance <= high:
        raise refuse("simulate", "tolerance", tolerance, "rad/s", f"{low} to {high}")
    if not 0.0 < period <= LONGEST_PERIOD:
        raise ValueError(f"step_tables: period = {period} s is not allowed; allowed: > 0 and <= {LONGEST_PERIOD} s")
    rungs = np.zeros(RUNGS, dtype=RUNG)
    share = tolerance / TOLERANCE
    rungs["largest_defect"], rungs["newton_tolerance"] = share * 1e-5, share * 1e-9
    rungs["fine"][SAMPLED_RUNGS:] = True
    sampling = np.zeros(SAMPLED_RUNGS, dtype=SAMPLING)
    speed_row, torque_row = np.eye(7)[2], torque_into_string(rig, np.eye(7))
    for r in range(RUNGS):
        step = period / 2**r
        from_state, from_torque = _variation_of_constants(rig, drive, step, RADAU_NODES)
        rungs[r]["node_from_state"] = from_state[:, 2, :].T
        rungs[r]["node_from_torque"] = from_torque[:, 2, :]
        rungs[r]["state_from_state"][:, :7] = from_state[-1].T
        rungs[r]["state_from_torque"][:, :7] = from_torque[-1].T
        rungs[r]["rate_from_state"][:, :7] = jacobian(rig, drive=drive).T * step
        rungs[r]["rate_from_torque"][:7] = friction_input(rig) * step
        if r < SAMPLED_RUNGS:
            count = SAMPLES >> r
            from_state, from_torque = _variation_of_constants(rig, drive, step, np.arange(1, count + 1) / count)
            for name, row in (("speed", speed_row), ("torque", torque_row)):
                sampling[r][f"{name}_from_state"][:, :count] = (row @ from_state).T
                sampling[r][f"{name}_from_torque"][:, :count] = (row @ from_torque).T
            sampling[r]["torque_row"], sampling[r]["torque_at_rest"] = torque_row, rig.T_r2
    rest = frictionless_state(rig, 0.0, drive)
    shift = np.zeros(1, dtype=SHIFT)
    shift["at_rest"][0, :7], shift["per_speed"][0, :7] = rest, frictionless_state(rig, 1.0, drive) - rest
    for table in (rungs, sampling, shift):
        table.flags.writeable = False
    return Tables(rig, drive, period, rungs, sampling, shift)


@inlined
def from_equilibrium(states: FloatArray, contact: Record, shift: Records, y: FloatArray) -> None:
    """The 7 `states` less the frictionless equilibrium of `contact`, which the stepper advances, into `y`."""
    for i in range(7):
        y[i] = states[i] - (shift[0].at_rest[i] + shift[0].per_speed[i] * contact.speed_reference)


@inlined
def to_states(y: FloatArray, contact: Record, shift: Records, states: FloatArray) -> None:
    """The way back from `y` to the 7 `states`."""
    for i in range(7):
        states[i] = y[i] + (shift[0].at_rest[i] + shift[0].per_speed[i] * contact.speed_reference)


def _variation_of_constants(
    rig: Rig, drive: Drive | None, step: float, times: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """State at the fractions `times` of a step, from the state at its start and T_r1 at the nodes.

    Returns arrays of shape (times, 7, 7) and (times, 7, NODES). The integrals against the powers of
    s / step come out of one augmented matrix exponential a time; the inverse Vandermonde matrix of
    the nodes turns them into integrals against the interpolating polynomial.
    """
    augmented = np.zeros((7 + NODES, 7 + NODES))
    augmented[:7, :7] = jacobian(rig, drive=drive) * step
    augmented[:7, 7] = friction_input(rig) * step
    augmented[range(7, 6 + NODES), range(8, 7 + NODES)] = 1.0
    exponentials = expm(augmented * times[:, None, None])
    powers = exponentials[:, :7, 7:] * [factorial(k) for k in range(NODES)]
    return exponentials[:, :7, :7], powers @ POWERS_FROM_NODES
