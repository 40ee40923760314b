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
from math import ceil, log2

import numpy as np

from drillrig_env.arrays import FloatArray, Record, Records
from drillrig_env.drive import Drive
from drillrig_env.jit.compiled import inlined
from drillrig_env.model import friction_input, frictionless_state, jacobian, torque_into_string
from drillrig_env.parameters import POSITIVE, refuse
from drillrig_env.rig import Rig
from drillrig_env.stepper.exponentials import BETWEEN, NODES, RADAU_NODES, doubled_steps, variation_of_constants
from drillrig_env.stepper.limits import check_computable, with_lag
from drillrig_env.stepper.units import Units, units_of

UNIT_RUNG = 17
UNITS = 1 << UNIT_RUNG
"""Length of a period in units, the steps of UNIT_RUNG: what parts of a period are counted in."""

DEPTH = 22
"""Rungs below, for what is over within no time: a bit that shoots through the stick zone, a disc without inertia."""

RUNGS = UNIT_RUNG + DEPTH + 1

SAMPLES = 16
"""Samples of bit speed and string torque taken inside a period, at equal distances."""

LONGEST_PERIOD = 0.1
"""Longest step (s, in the rig's own unit of time) that the tolerances were established for."""

_ROUNDING = 1e-9

_TRIED_GROWTH, _UNTRIED_GROWTH = 36.0, 12.0
"""Rate (1/s, in the own unit of time) of a bit that falling friction drives on, above which bounds are tighter.

The first is for a rig much like the chapter's, on which the bounds were tried, the second for others.
"""

_UNTRIED_SHARE = 0.3
"""What is left of the bounds on a rig that they were not tried on: its errors may grow more from step to step."""

_DIES = 15.0
"""Rate times the longest step of a mode that dies so soon within it that the defect at its start tells."""

_LARGEST_TURN = 1.2
"""How far (rad) the fastest swing of the string may turn within a step: nodes see no more of it."""

_FASTEST_SWING = 384.0
"""What swings faster (rad/s, in the rig's own unit of time) hardly moves the bit, and bounds the steps no further."""

_LARGEST_SERIES = 3.0
"""Largest rate times step of a mode that a Taylor series follows without losing digits."""

TOLERANCE = 1e-6
"""What the error of any speed (rad/s) stays below over 20 s, unless another tolerance is asked for."""

_TOLERANCES = (1e-7, 1e-3)

SAMPLED_RUNGS = 4
"""The longest steps, of the rungs below this one, span several samples and have tables for them."""

STATE = 8
"""The 7 states and a pad, so that a row fills whole vector registers."""


RUNG = np.dtype(
    [
        ("node_from_state", "f8", (7, NODES)),
        ("node_from_torque", "f8", (NODES, NODES)),
        ("between_from_state", "f8", (7, NODES)),
        ("between_from_torque", "f8", (NODES, NODES)),
        ("state_from_state", "f8", (7, STATE)),
        ("state_from_torque", "f8", (NODES, STATE)),
        ("rate_from_state", "f8", (7, STATE)),
        ("rate_from_torque", "f8", STATE),
        ("largest_defect", "f8"),  # N m, of a step that is taken
        ("newton_tolerance", "f8"),  # N m
        ("clearly_beyond", "f8"),  # rad/s, how far beyond a kink an iterate tells that the step crosses it
        ("settled", "f8"),  # rad/s, what may be left of the fast settling where the bit leaves the stick zone
        ("landed", "f8"),  # rad/s, how near to a kink a step that leads there ends
        ("slowest_collars", "f8"),  # rad/s, below which disc 2 turns backwards, where a constant T_r2 does not hold
        ("growth", "f8"),  # caution for a friction that falls by 1 N m s/rad: what it makes of errors
        ("unit", "f8", STATE),  # of each state
        ("first", "i8"),  # the rung of the longest steps
        ("series", "b1"),  # whether a Taylor series over the step keeps its digits
        ("watched", "b1"),  # whether nodes alone may not see a mode that is fast and lasts
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
        ("torque_per_speed", "f8"),  # what 1 rad/s of the speed reference adds to it, N m s/rad
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


@np.errstate(over="ignore", invalid="ignore")  # an impossible rig is found out by its first states
def build_tables(rig: Rig, period: float, tolerance: float = TOLERANCE, drive: Drive | None = None) -> Tables:
    """Build the tables for a rig and a period in s; > 0. Steps are no longer than LONGEST_PERIOD.

    `tolerance` (rad/s, in the rig's own unit of speed: see `units_of`) is what the error of any speed stays below over
    20 s: 1e-7 to 1e-3. The bounds on a step's errors that keep it there were found by trial, with a margin of 2 or more
    (see the tests).
    `drive` takes the place of the rig's own.
    Raises `ValueError` for a value that is not allowed.
    """
    low, high = _TOLERANCES
    if not low <= tolerance <= high:
        raise refuse("simulate", "tolerance", tolerance, "rad/s", f"{low} to {high}")
    if not POSITIVE.holds(period):
        raise refuse("step_tables", "period", period, "s", POSITIVE)
    check_computable(rig, drive)
    rig = with_lag(rig)
    units = units_of(rig)
    M, b, step = _in_units(rig, drive, units, period)
    rungs = np.zeros(RUNGS, dtype=RUNG)
    longest = min(LONGEST_PERIOD, _LARGEST_TURN / min(max(_swinging(M), 1e-9), _FASTEST_SWING))
    first = max(0, ceil(log2(step / longest) - _ROUNDING))
    tried = first == 0 and _is_much_like_the_chapters(M)
    _write_bounds(rungs, units, tolerance / TOLERANCE * (1.0 if tried else _UNTRIED_SHARE))
    modes = np.linalg.eigvals(M)
    lasting = (np.abs(modes) * longest > _LARGEST_SERIES) & (np.abs(modes.real) * longest < _DIES)
    rungs["watched"] = lasting.any() or not tried
    fastest = np.abs(modes).max() * step
    rungs["growth"] = units.time / rig.J_1 / (_TRIED_GROWTH if tried else _UNTRIED_GROWTH)
    rungs["slowest_collars"] = -rig.omega_s if rig.T_r2 > 0.0 else -np.inf
    rungs["first"], rungs["fine"][first + SAMPLED_RUNGS :] = first, True
    rungs["series"] = fastest / 2.0 ** np.arange(RUNGS) <= _LARGEST_SERIES
    per_state, per_torque = np.outer(1.0 / units.states, units.states), units.states / units.torque
    between_from_state, between_from_torque = doubled_steps(M, b, step, BETWEEN, RUNGS)
    tables = variation_of_constants(M, b, step, RADAU_NODES, UNIT_RUNG + 1)
    deep = doubled_steps(M, b, step / (2.0 * UNITS), RADAU_NODES, DEPTH)
    from_state, from_torque = (np.concatenate(both) for both in zip(tables, deep, strict=True))
    rungs["node_from_state"] = from_state[:, :, 2].transpose(0, 2, 1) * per_state[:, 2, None]
    rungs["node_from_torque"] = from_torque[:, :, 2] * per_torque[2]
    rungs["between_from_state"] = between_from_state[:, :, 2].transpose(0, 2, 1) * per_state[:, 2, None]
    rungs["between_from_torque"] = between_from_torque[:, :, 2].transpose(0, 2, 1) * per_torque[2]
    rungs["state_from_state"][:, :, :7] = from_state[:, -1].transpose(0, 2, 1) * per_state
    rungs["state_from_torque"][:, :, :7] = from_torque[:, -1].transpose(0, 2, 1) * per_torque
    steps = period / 2.0 ** np.arange(RUNGS)
    rungs["rate_from_state"][:, :, :7] = jacobian(rig, drive=drive).T * steps[:, None, None]
    rungs["rate_from_torque"][:, :7] = friction_input(rig) * steps[:, None]
    sampling = np.zeros(SAMPLED_RUNGS, dtype=SAMPLING)
    speed_row, torque_row = np.eye(7)[2], torque_into_string(rig, np.eye(7))
    for r in range(SAMPLED_RUNGS):
        count = SAMPLES >> r
        times = np.arange(1, count + 1) / count
        (from_state,), (from_torque,) = variation_of_constants(M, b, step / 2**r, times)
        from_state, from_torque = from_state * per_state.T, from_torque * per_torque[:, None]
        for name, row in (("speed", speed_row), ("torque", torque_row)):
            sampling[r][f"{name}_from_state"][:, :count] = (row @ from_state).T
            sampling[r][f"{name}_from_torque"][:, :count] = (row @ from_torque).T
        sampling[r]["torque_row"], sampling[r]["torque_at_rest"] = torque_row, rig.T_r2
        sampling[r]["torque_per_speed"] = rig.C_1 + rig.C_2
    rest = frictionless_state(rig, 0.0, drive)
    shift = np.zeros(1, dtype=SHIFT)
    shift["at_rest"][0, :7], shift["per_speed"][0, :7] = (
        rest,
        (frictionless_state(rig, units.speed, drive) - rest) / units.speed,
    )
    for table in (rungs, sampling, shift):
        table.flags.writeable = False
    return Tables(rig, drive, period, rungs, sampling, shift)


step_tables = lru_cache(maxsize=64)(build_tables)
"""`build_tables`, or what it has built before."""


def _in_units(rig: Rig, drive: Drive | None, units: Units, period: float) -> tuple[FloatArray, FloatArray, float]:
    """Jacobian, input of the friction torque and period in the rig's own units."""
    M = jacobian(rig, drive=drive) * np.outer(1.0 / units.states, units.states) * units.time
    return M, friction_input(rig) / units.states * (units.torque * units.time), period / units.time


def _swinging(M: FloatArray) -> float:
    """The highest frequency at which the string swings with its top held, in rad/s; 0 where damping lets none."""
    modes = np.linalg.eigvals(M[:4, :4])
    swing = modes[np.abs(modes.imag) > np.abs(modes.real)]
    return float(np.abs(swing.imag).max(initial=0.0))


def _is_much_like_the_chapters(M: FloatArray) -> bool:
    """Whether every rate of discs and shafts is the chapter's within a factor of 2, in the rig's own units."""
    rates, usual = np.abs(M[:5, :5]), np.abs(jacobian(Rig())[:5, :5])
    return bool(np.all((rates <= 2.0 * usual) & (usual <= 2.0 * rates)))


def _write_bounds(rungs: np.ndarray, units: Units, share: float) -> None:
    """What the stepper calls small, for a tolerance that is a share of TOLERANCE."""
    rungs["largest_defect"], rungs["newton_tolerance"] = share * 1e-5 * units.torque, share * 1e-9 * units.torque
    rungs["clearly_beyond"], rungs["settled"] = 0.02 * units.speed, 1e-10 * units.speed
    rungs["landed"] = 1e-6 * units.speed
    rungs["unit"][:, :7], rungs["unit"][:, 7] = units.states, 1.0


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
