"""One periodic orbit: the stick-slip orbit p1 by shooting, the unstable orbit p2 by harmonic balance."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.model import wound_up
from drillrig_env.parameters import POSITIVE, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stability.fold import family_for, fold_speed, load_of
from drillrig_env.stability.fourier_orbit import FourierOrbit
from drillrig_env.stability.orbit import SIGNAL_COLUMNS, PeriodicOrbit, describe_orbit, difference_step
from drillrig_env.stability.return_map import next_crossings
from drillrig_env.stability.stable_sets import critical_speed

_FREE = [0, 1, 3, 4, 5, 6]  # the states that vary on the section x_3 = omega_ref
_SETTLING_RETURNS = (12, 120)  # of a wound-up rig before Newton's method; the second where the first leads nowhere
_NEWTON_LIMIT = 30
_CLOSED = 1e-7
"""An orbit counts as closed when it returns within this (in every state's own unit)."""


class NoOrbitError(ValueError):
    """There is no such periodic orbit; the message says why and where there is one."""


def stick_slip_orbit(
    rig: RigLike, friction: FrictionLike, speed_reference: float, guess: FloatArray | None = None
) -> PeriodicOrbit:
    """The stick-slip orbit p1, by shooting on the fast stepper; `guess` is a state near its section point.

    Where the guess leads nowhere, a wound-up rig finds the orbit, as it does without a guess.

    Raises `NoOrbitError` where the rig does not stick and slip, `ValueError` for a speed reference
    that is not positive.
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    _check_speed(speed_reference)
    orbit = None if guess is None else _shoot(rig, friction, speed_reference, np.array(guess, dtype=float)[None], 1)
    for settling in _SETTLING_RETURNS:
        if orbit is None:
            wound = wound_up(rig, friction, speed_reference).reshape(1, 7)
            orbit = _shoot(rig, friction, speed_reference, wound, settling)
    if orbit is None:
        raise _no_stick_slip(rig, friction, speed_reference)
    return orbit


def _shoot(rig: Rig, friction: Friction, speed_reference: float, x: FloatArray, settling: int) -> PeriodicOrbit | None:
    """The orbit p1 from a state (1, 7), by Newton's method after some returns; None where that leads to none.

    A step that does not bring the return closer is left out, and the rig returns by itself instead: p1 attracts, and
    near the fold it does so from further away than Newton's method finds it.
    """
    for _ in range(settling):
        x, times = next_crossings(rig, friction, speed_reference, x)
        if np.isnan(times[0]):
            return None
    image, times = next_crossings(rig, friction, speed_reference, x)
    for _ in range(_NEWTON_LIMIT):
        if np.isnan(times[0]):
            return None
        gap = (image - x)[0, _FREE]
        if np.abs(gap).max() < _CLOSED:
            orbit = describe_orbit(rig, friction, speed_reference, float(times[0]), x[0])
            return orbit if orbit.stuck > 0.0 else None
        tried = x.copy()
        tried[0, _FREE] += np.linalg.solve(np.eye(6) - _return_slopes(rig, friction, speed_reference, x[0]), gap)
        returned, times = next_crossings(rig, friction, speed_reference, tried)
        if np.isnan(times[0]) or not np.abs(returned - tried)[0, _FREE].max() < np.abs(gap).max():
            tried = image
            returned, times = next_crossings(rig, friction, speed_reference, tried)
        x, image = tried, returned
    return None


def slipping_orbit(rig: RigLike, friction: FrictionLike, speed_reference: float) -> PeriodicOrbit:
    """The unstable orbit p2, which never sticks, between the critical speed and the fold.

    Raises `NoOrbitError` outside that range, which the message states.
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    _check_speed(speed_reference)
    hopf, fold = float(critical_speed(rig, friction)), float(fold_speed(rig, friction))
    if not hopf < speed_reference <= fold:
        raise NoOrbitError(
            f"p2: no orbit at speed_reference = {speed_reference:g} rad/s; "
            f"allowed: above the critical speed {hopf:.6g} and up to the fold {fold:.6g} rad/s"
        )
    v_b = float(friction.v_b)
    log_gain = float(load_of(rig, friction)) + v_b * (rig.omega_s - speed_reference)
    family = family_for(rig, friction)
    deepest = v_b * (fold - rig.omega_s)
    depth = brentq(
        lambda a: float(family.guess(a)[0]) - log_gain, 0.0, min(deepest * 1.001, family.depth[-1]), xtol=1e-12
    )
    return slipping_orbit_of_depth(rig, friction, depth)


def slipping_orbit_of_depth(rig: Rig, friction: Friction, depth: float) -> PeriodicOrbit:
    """The orbit of the slipping family with that depth a = v_b (omega_ref - lowest bit speed), for a friction."""
    friction = friction.single()
    family = family_for(rig, friction)
    q, frequency, log_gain = family.orbit(depth)
    speed_reference = rig.omega_s + (float(load_of(rig, friction)) - log_gain) / float(friction.v_b)
    orbit = FourierOrbit(rig, friction, speed_reference, q, frequency, log_gain)
    lowest, highest = orbit.extremes(SIGNAL_COLUMNS)
    state = orbit.states(np.array(orbit.section_phase))
    return PeriodicOrbit(
        rig, friction, "p2", speed_reference, orbit.period, state, lowest, highest, 0.0, orbit.multipliers
    )


def _return_slopes(rig: Rig, friction: Friction, speed_reference: float, state: FloatArray) -> FloatArray:
    """Derivative of the return map on the section, by central differences; shape (6, 6)."""
    size = difference_step(rig, friction, speed_reference)
    steps = size * np.eye(7)[_FREE]
    ends, _ = next_crossings(rig, friction, speed_reference, np.concatenate([state + steps, state - steps]))
    return np.asarray((ends[:6] - ends[6:])[:, _FREE].T / (2 * size))


def _check_speed(speed_reference: float) -> None:
    if not POSITIVE.holds(speed_reference):
        raise refuse("periodic orbit", "speed_reference", speed_reference, "rad/s", POSITIVE)


def _no_stick_slip(rig: Rig, friction: Friction, speed_reference: float) -> NoOrbitError:
    fold = float(fold_speed(rig, friction))
    if np.isnan(fold):
        where = "friction is so weak that it never does"
    elif speed_reference <= rig.omega_s:
        where = (
            f"up to omega_s = {rig.omega_s:g} rad/s the bit counts as standing still, and friction as static; "
            f"it does above that and below the fold, {fold:.6g} rad/s"
        )
    elif speed_reference > fold:
        where = f"it does below the fold, {fold:.6g} rad/s"
    else:
        where = f"none was found, though this is below the fold, {fold:.6g} rad/s"
    return NoOrbitError(f"p1: the rig does not stick and slip at speed_reference = {speed_reference:g} rad/s; {where}")
