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

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, log2

import numpy as np

from drillrig_env.arrays import FloatArray
from drillrig_env.drive import Drive, Limiting
from drillrig_env.model import friction_input, frictionless_state, jacobian, torque_into_string
from drillrig_env.parameters import POSITIVE, refuse
from drillrig_env.rig import Rig
from drillrig_env.stepper.ladder import LADDER, RUNGS, SAMPLED_RUNGS
from drillrig_env.stepper.limits import check_computable, with_lag
from drillrig_env.stepper.modes import arranged, join_modes
from drillrig_env.stepper.rungs import in_units, longest_rungs, sampling_of
from drillrig_env.stepper.shortest import CALL, Shortest, address_of
from drillrig_env.stepper.units import Units, units_of

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


@dataclass(frozen=True, eq=False)
class Tables:
    """The ladders of some rigs for one period (s) of held speed reference and one drive.

    `ladders` holds a LADDER record a rig, and after these the ones of further modes (`drillrig_env.stepper.modes`), for
    kernels, which call `make_shortest` by its address: whoever hands them the ladders keeps the tables.
    """

    rigs: tuple[Rig, ...]
    drive: Drive | None
    period: float
    ladders: np.ndarray
    make_shortest: Callable[[int], int]


@np.errstate(over="ignore", invalid="ignore")  # an impossible rig is found out by its first states
def build_tables(
    rigs: Sequence[Rig],
    period: float,
    tolerance: float = TOLERANCE,
    drive: Drive | None = None,
    known: Tables | None = None,
) -> Tables:
    """Build the tables for rigs and a period in s; > 0. Steps are no longer than LONGEST_PERIOD.

    `tolerance` (rad/s, in a rig's own unit of speed: see `units_of`) is what the error of any speed stays below over
    20 s: 1e-7 to 1e-3. The bounds on a step's errors that keep it there were found by trial, with a margin of 2 or more
    (see the tests).
    `drive` takes the place of the rigs' own. What `known` tables of the same period and tolerance have is taken from
    there.
    Raises `ValueError` for a value that is not allowed.
    """
    low, high = _TOLERANCES
    if not low <= tolerance <= high:
        raise refuse("simulate", "tolerance", tolerance, "rad/s", f"{low} to {high}")
    if not POSITIVE.holds(period):
        raise refuse("step_tables", "period", period, "s", POSITIVE)
    for rig in rigs:
        check_computable(rig, drive)
    modes, places = arranged(rigs, drive)
    ladders = np.zeros(len(modes), dtype=LADDER)
    there = {} if known is None or known.drive != drive else dict(zip(known.rigs, known.ladders, strict=False))
    for number, mode in enumerate(modes):
        if mode.rig in there and mode.drive == drive:
            ladders[number] = there[mode.rig]
        else:
            _write(ladders[number], with_lag(mode.rig), mode.drive, period, tolerance)
    make_shortest = CALL(Shortest([(mode.rig, mode.drive) for mode in modes], period, ladders))
    ladders["number"], ladders["make_shortest"] = np.arange(len(modes)), address_of(make_shortest)
    ladders["shortest"] = 0
    for rig, own in zip(rigs, places, strict=True):
        join_modes(ladders, own, modes, rig, drive)
    seen = ladders.view()
    seen.flags.writeable = False
    return Tables(tuple(rigs), drive, period, seen, make_shortest)


@lru_cache(maxsize=64)
def step_tables(rig: Rig, period: float, tolerance: float = TOLERANCE, drive: Drive | None = None) -> Tables:
    """`build_tables` for one rig, or what it has built before."""
    return build_tables((rig,), period, tolerance, drive)


def _write(ladder: np.void, rig: Rig, drive: Drive | Limiting | None, period: float, tolerance: float) -> None:
    """Write all but the shortest steps into a rig's ladder."""
    units = units_of(rig)
    M, b, step = in_units(rig, drive, units, period)
    longest = min(LONGEST_PERIOD, _LARGEST_TURN / min(max(_swinging(M), 1e-9), _FASTEST_SWING))
    first = max(0, ceil(log2(step / longest) - _ROUNDING))
    tried = first == 0 and _is_much_like_the_chapters(M)
    _write_bounds(ladder, units, tolerance / TOLERANCE * (1.0 if tried else _UNTRIED_SHARE))
    modes = np.linalg.eigvals(M)
    lasting = (np.abs(modes) * longest > _LARGEST_SERIES) & (np.abs(modes.real) * longest < _DIES)
    ladder["watched"] = lasting.any() or not tried
    ladder["growth"] = units.time / rig.J_1 / (_TRIED_GROWTH if tried else _UNTRIED_GROWTH)
    ladder["first"], ladder["fine_from"] = first, first + SAMPLED_RUNGS
    fastest = np.abs(modes).max() * step
    ladder["series_from"] = np.count_nonzero(~(fastest / 2.0 ** np.arange(RUNGS) <= _LARGEST_SERIES))
    ladder["rate_from_state"][:, :7] = jacobian(rig, drive=drive).T * period
    ladder["rate_from_torque"][:7] = friction_input(rig) * period
    ladder["rungs"] = longest_rungs(M, b, step, units)
    ladder["sampling"] = sampling_of(rig, M, b, step, units)
    ladder["torque_row"][:7], ladder["torque_at_rest"] = torque_into_string(rig, np.eye(7)), rig.T_r2
    ladder["torque_per_speed"] = rig.C_1 + rig.C_2
    rest = frictionless_state(rig, 0.0, drive)
    ladder["at_rest"][:7] = rest
    ladder["per_speed"][:7] = (frictionless_state(rig, units.speed, drive) - rest) / units.speed


def _swinging(M: FloatArray) -> float:
    """The highest frequency at which the string swings with its top held, in rad/s; 0 where damping lets none."""
    modes = np.linalg.eigvals(M[:4, :4])
    swing = modes[np.abs(modes.imag) > np.abs(modes.real)]
    return float(np.abs(swing.imag).max(initial=0.0))


def _is_much_like_the_chapters(M: FloatArray) -> bool:
    """Whether every rate of discs and shafts is the chapter's within a factor of 2, in the rig's own units."""
    rates, usual = np.abs(M[:5, :5]), np.abs(jacobian(Rig())[:5, :5])
    return bool(np.all((rates <= 2.0 * usual) & (usual <= 2.0 * rates)))


def _write_bounds(ladder: np.void, units: Units, share: float) -> None:
    """What the stepper calls small, for a tolerance that is a share of TOLERANCE."""
    ladder["largest_defect"], ladder["newton_tolerance"] = share * 1e-5 * units.torque, share * 1e-9 * units.torque
    ladder["clearly_beyond"], ladder["settled"] = 0.02 * units.speed, 1e-10 * units.speed
    ladder["landed"] = 1e-6 * units.speed
    ladder["unit"][:7], ladder["unit"][7] = units.states, 1.0
