"""Rigs that cannot be computed: what is too fast for the shortest step, or too large for a double beside the rest."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import lru_cache
from math import inf, isfinite, log, sqrt

import numpy as np

from drillrig_env.drive import Drive, Limiting
from drillrig_env.model import STATE_NAMES, STATE_UNITS, frictionless_state
from drillrig_env.parameters import refuse
from drillrig_env.rig import Rig
from drillrig_env.stepper.units import time_of, units_of

FASTEST_RATE = 1e12
"""Rates (1/s, in the rig's own unit of time) that the shortest steps still resolve."""

_DAMPED = 1e3
"""How much slower a rate of damping must be, beside which doubles must keep the other disc's damping."""

_LARGEST_STATE = 1e12
"""A state beside which doubles resolve 1e-4 of its unit."""

_LARGEST_UNIT = 1e100
"""A unit of the rig's own, or 1 over one, from which doubles can go up and down by as much again."""

_LARGEST_LIMITED = 1e6
"""A speed (rad/s, in the rig's own unit) beside which doubles resolve that of a bit that sticks."""

_CHAPTER = Rig()


@lru_cache(maxsize=1024)
def check_computable(rig: Rig, drive: Drive | None = None) -> None:
    """Raise `ValueError`, naming the parameter, for a rig whose rates or states at rest are beyond what doubles hold.

    `drive` takes the place of the rig's own.
    """
    time, own, rig = _check_units(rig), rig, with_lag(rig)
    k_p, k_i, K_E = (drive.k_p, drive.k_i, drive.remaining_K_E(rig)) if drive else (rig.k_p, rig.k_i, rig.K_E)
    with np.errstate(all="ignore"):
        rates = {
            "k_1 J_1": _root(rig.k_1, rig.J_1),
            "k_1 J_2": _root(rig.k_1, rig.J_2),
            "k_2 J_2": _root(rig.k_2, rig.J_2),
            "k_2 J_3": _root(rig.k_2, rig.J_3),
            "d_1 J_1": _DAMPED * _ratio(rig.d_1, rig.J_1),
            "d_1 J_2": _DAMPED * _ratio(rig.d_1, rig.J_2),
            "d_2 J_2": _DAMPED * _ratio(rig.d_2, rig.J_2),
            "d_2 J_3": _DAMPED * _ratio(rig.d_2, rig.J_3),
            "eta C_m J_3": rig.eta * _ratio(rig.eta, 1.0) * _ratio(rig.C_m, rig.J_3),
            "C_1 J_1": _ratio(rig.C_1, rig.J_1),
            "C_2 J_2": _ratio(rig.C_2, rig.J_2),
            "R L": _ratio(rig.R, rig.L),
            "eta K_T k_p L J_3": _root(rig.eta, rig.L) * _root(rig.K_T, rig.J_3) * sqrt(k_p),
            "eta K_T K_E L J_3": rig.eta * _root(rig.K_T, rig.L) * _root(abs(K_E), rig.J_3),
            "eta K_T k_i L J_3": (_ratio(rig.eta, rig.L) * _ratio(rig.K_T, rig.J_3) * k_i) ** (1.0 / 3.0),
            "T_r2 omega_s J_2": _ratio(_ratio(rig.T_r2, rig.omega_s), rig.J_2),
        }
        if drive is not None and drive.current_limit is not None:
            rates["k_i k_p"], rates["eta K_E k_p"] = _ratio(k_i, k_p), _ratio(rig.eta * abs(K_E), k_p)
            _check_limited(rig, drive)
        units = units_of(rig)
        at_speed = np.abs(frictionless_state(rig, units.speed, drive)) / units.states
    names, rate = max(rates.items(), key=lambda item: item[1] if isfinite(item[1]) else inf)
    if not rate * time <= FASTEST_RATE:
        _refuse(own, drive, names, f"a value with which no rate in the rig exceeds {FASTEST_RATE:g} / {time:g} s")
    if not np.all(at_speed <= _LARGEST_STATE):
        state = int(np.flatnonzero(~(at_speed <= _LARGEST_STATE))[0])
        largest = f"{_LARGEST_STATE * units.states[state]:g} {STATE_UNITS[state]}"
        reason = f"a value with which {STATE_NAMES[state]} stays below {largest}"
        _refuse(own, drive, {0: "k_1 C_1", 1: "T_r2 C_1 C_2"}.get(state, "R C_m C_1 C_2 T_f K_E eta K_T k_i"), reason)


def _check_limited(rig: Rig, drive: Drive) -> None:
    """Raise `ValueError` where nothing but the limit of its current bounds how fast a drive would turn the rig."""
    speed = float(np.abs(frictionless_state(rig, 0.0, Limiting(drive, 1))[2]))
    if not speed <= _LARGEST_LIMITED * units_of(rig).speed:
        raise refuse(
            "Drive",
            "current_limit",
            drive.current_limit,
            "A",
            f"none on a rig that loses so little: without friction it would turn at {speed:g} rad/s; or C_1, C_2 or "
            f"C_m with which that is below {_LARGEST_LIMITED * units_of(rig).speed:g} rad/s",
        )


def with_lag(rig: Rig) -> Rig:
    """The rig, its armature made as slow as the shortest steps resolve: no speed shows how much faster it is."""
    least = rig.R * time_of(rig) / FASTEST_RATE
    return replace(rig, L=least) if rig.L < least <= _LARGEST_UNIT else rig


def _check_units(rig: Rig) -> float:
    """The rig's time (s). Raises `ValueError` where it, or another unit of the rig, leaves no room in a double."""
    time = time_of(rig)
    low, high = 1.0 / _LARGEST_UNIT, _LARGEST_UNIT
    for names, what, value, unit in (
        ("J_1", "the period of the string", time, "s"),
        ("J_1", "the torque that turns J_1 in that time", rig.J_1 / time / time if time else inf, "N m"),
        ("eta K_T", "the motor's torque", rig.eta * rig.K_T, "N m/A"),
    ):
        if not low <= value <= high:
            _refuse(rig, None, names, f"a value with which {what} is {low:g} to {high:g} {unit}")
    return time


def _ratio(above: float, below: float) -> float:
    return float(np.float64(above) / np.float64(below))


def _root(above: float, below: float) -> float:
    return sqrt(_ratio(above, below))


def _refuse(rig: Rig, drive: Drive | None, names: str, allowed: str) -> None:
    """Refuse the one of some parameters, or of the string's, that lies farthest from the chapter's value."""
    own = {} if drive is None else {"k_p": drive.k_p, "k_i": drive.k_i}

    def distance(name: str) -> float:
        value, usual = own.get(name, getattr(rig, name)), getattr(_CHAPTER, name)
        return abs(log(value) - log(usual)) if value > 0.0 and usual > 0.0 else 0.0

    name = max([*names.split(), "J_1", "J_2", "k_1", "k_2"], key=distance)
    unit = next(f" {item.metadata['unit']}".rstrip() for item in fields(rig) if item.name == name)
    where = "Drive" if name in own else "Rig"
    value = own.get(name, getattr(rig, name))
    raise ValueError(f"{where}: {name} = {value:g}{unit} is beyond what can be computed; allowed: {allowed}")
