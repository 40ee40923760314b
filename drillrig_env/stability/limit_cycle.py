"""One periodic orbit: the stick-slip orbit p1 by shooting, the unstable orbit p2 by harmonic balance."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.parameters import POSITIVE, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stability.continuation import orbit_on_branch
from drillrig_env.stability.end_of_stick_slip import end_of_stick_slip
from drillrig_env.stability.fold import family_for, fold_speed, load_of
from drillrig_env.stability.fourier_orbit import FourierOrbit
from drillrig_env.stability.orbit import SIGNAL_COLUMNS, PeriodicOrbit, describe_orbit
from drillrig_env.stability.return_map import Passage, ReturnMap
from drillrig_env.stability.shooting import find_stick_slip, settled_stick_slip
from drillrig_env.stability.slipping_orbits import SlippingOrbits
from drillrig_env.stability.stable_sets import critical_speed

_SLOWER = (0.98, 0.9, 0.7, 0.4)
"""Shares of a speed reference at which a branch is taken up that leads to it."""

_NEAR = 1.0 - 1e-4
"""The share of the speed at which p1 grazes from which the grazing orbit leads to it."""


class NoOrbitError(ValueError):
    """There is no such periodic orbit; the message says why and where there is one."""


def stick_slip_orbit(
    rig: RigLike, friction: FrictionLike, speed_reference: float, guess: FloatArray | None = None
) -> PeriodicOrbit:
    """The stick-slip orbit p1, by shooting on the fast stepper; `guess` is a state near its section point.

    `rig` and `friction`, a single one, are given as `Rig.of` and `Friction.of` take them; `speed_reference` is in
    rad/s, and `guess` has the shape (7,).

    Where the guess leads nowhere, a wound-up rig finds the orbit, as it does without a guess.

    Raises `NoOrbitError` where the rig does not stick and slip, `ValueError` for a speed reference
    that is not positive.

    >>> from drillrig_env import Friction, Rig, stability
    >>> orbit = stability.stick_slip_orbit(Rig(), Friction(10.0), speed_reference=2.0)
    >>> round(orbit.period, 2), orbit.stable  # s
    (2.35, True)
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    _check_speed(speed_reference)
    returns = ReturnMap(rig, friction)
    passage = find_stick_slip(returns, speed_reference, guess) or _on_the_branch(returns, speed_reference)
    if passage is None:
        raise _no_stick_slip(rig, friction, speed_reference)
    return describe_orbit(rig, friction, speed_reference, passage)


def slipping_orbit(rig: RigLike, friction: FrictionLike, speed_reference: float) -> PeriodicOrbit:
    """The unstable orbit p2, which never sticks, between the critical speed and the fold.

    `rig` and `friction`, a single one, are given as `Rig.of` and `Friction.of` take them; `speed_reference` is in
    rad/s.

    Raises `NoOrbitError` outside that range, which the message states, and `ValueError` for another law than the
    exponential one.

    >>> from drillrig_env import Friction, Rig, stability
    >>> orbit = stability.slipping_orbit(Rig(), Friction(10.0), speed_reference=2.4)
    >>> orbit.stuck, orbit.stable
    (0.0, False)
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    _check_speed(speed_reference)
    load = float(load_of(rig, friction))
    hopf, fold = float(critical_speed(rig, friction)), float(fold_speed(rig, friction))
    if not hopf < speed_reference <= fold:
        raise NoOrbitError(
            f"p2: no orbit at speed_reference = {speed_reference:g} rad/s; "
            f"allowed: above the critical speed {hopf:.6g} and up to the fold {fold:.6g} rad/s"
        )
    v_b = float(friction.v_b)
    log_gain = load + v_b * (rig.omega_s - speed_reference)
    family = family_for(rig, friction)
    deepest = v_b * (fold - rig.omega_s)
    depth = brentq(
        lambda a: float(family.guess(a)[0]) - log_gain, 0.0, min(deepest * 1.001, family.depth[-1]), xtol=1e-12
    )
    return slipping_orbit_of_depth(family, friction, depth)


def slipping_orbit_of_depth(family: SlippingOrbits, friction: Friction, depth: float) -> PeriodicOrbit:
    """The orbit of a rig's family with that depth a = v_b (omega_ref - lowest bit speed), for a friction."""
    rig, friction = family.rig, friction.single()
    q, frequency, log_gain = family.orbit(depth)
    speed_reference = rig.omega_s + (float(load_of(rig, friction)) - log_gain) / float(friction.v_b)
    orbit = FourierOrbit(rig, friction, speed_reference, q, frequency, log_gain)
    lowest, highest = orbit.extremes(SIGNAL_COLUMNS)
    state = orbit.states(np.array(orbit.section_phase))
    return PeriodicOrbit(
        rig, friction, "p2", speed_reference, orbit.period, state, lowest, highest, 0.0, orbit.multipliers
    )


def _check_speed(speed_reference: float) -> None:
    if not POSITIVE.holds(speed_reference):
        raise refuse("periodic orbit", "speed_reference", speed_reference, "rad/s", POSITIVE)


def _on_the_branch(returns: ReturnMap, speed_reference: float) -> Passage | None:
    """The orbit p1 to which no wound-up rig comes, on the branch of one at a lower speed, or of that which grazes."""
    rig, friction = returns.rig, returns.friction
    try:
        end = end_of_stick_slip(rig, friction)
    except (ValueError, FloatingPointError):
        return None
    if not rig.omega_s < speed_reference <= end.speed:
        return None
    for share in _SLOWER:
        orbit = settled_stick_slip(returns, share * speed_reference)
        found = orbit and orbit_on_branch(returns, share * speed_reference, orbit, speed_reference)
        if found:
            return found
    if end.kind != "grazing" or friction.law != "exponential":
        return None
    near = max(speed_reference, _NEAR * float(end.speed))
    guess = slipping_orbit(rig, friction, float(end.speed)).state + (near - float(end.speed)) * np.eye(7)[2]
    orbit = find_stick_slip(returns, near, guess)
    return orbit and orbit_on_branch(returns, near, orbit, speed_reference)


def _no_stick_slip(rig: Rig, friction: Friction, speed_reference: float) -> NoOrbitError:
    try:
        end = float(end_of_stick_slip(rig, friction).speed)
    except (ValueError, FloatingPointError) as error:
        return NoOrbitError(f"p1: no stick-slip found at speed_reference = {speed_reference:g} rad/s; {error}")
    if np.isnan(end):
        where = "friction is so weak that it never does"
    elif speed_reference <= rig.omega_s:
        where = (
            f"up to omega_s = {rig.omega_s:g} rad/s the bit counts as standing still, and friction as static; "
            f"it does above that and up to {end:.6g} rad/s"
        )
    elif speed_reference > end:
        where = f"it does up to {end:.6g} rad/s"
    else:
        where = f"none was found, though it does up to {end:.6g} rad/s"
    return NoOrbitError(f"p1: the rig does not stick and slip at speed_reference = {speed_reference:g} rad/s; {where}")
