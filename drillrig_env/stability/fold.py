"""The fold: the speed reference at which stick-slip grazes, for one friction or thousands at once."""

from __future__ import annotations

from itertools import product

import numpy as np

from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.parameters import refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stability.slipping_orbits import (
    FEW_SAMPLES,
    FIRST_REACH,
    MANY_SAMPLES,
    SlippingOrbits,
    slipping_orbits,
)
from drillrig_env.stability.stable_sets import critical_speed

REACHES = tuple(FIRST_REACH * 2.0**doubled for doubled in range(4))
"""Depths to which a family of slipping orbits is followed, one after the other: 96 is 500 N on the chapter's rig."""

_GROWTH = 1.0
"""How much faster than the depth, at most, the load grows, as the logarithm of a factor: 0.6 over rigs at random."""


def fold_speed(rig: RigLike, friction: FrictionLike) -> Quantity:
    """Speed reference (rad/s) of the orbit that grazes the stick zone, at which p1 and p2 meet.

    There stick-slip ends, and above it only calm rotation is left, but for heavy loads and friction that falls fast:
    `end_of_stick_slip` tells. Between the critical speed and this one a rig can do either: a sticking rig is freed for
    certain only by going past the end. NaN where friction is so weak that the critical speed is 0: no
    stick-slip, no bistable region. One entry a rig for a batch of frictions.

    It is exact to 1e-7 rad/s; the true turning point lies about 1e-6 rad/s above it. Under another law than the
    exponential one it is where the followed stick-slip orbit turns back, at grazing or before; `ValueError` where it
    only loses its stability.

    >>> from drillrig_env import Friction, Rig, stability
    >>> round(float(stability.fold_speed(Rig(), Friction(20.0))), 2)  # rad/s
    4.79
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    if friction.law != "exponential":
        return _followed_to_fold(rig, friction)
    load = load_of(rig, friction)
    bistable = np.asarray(critical_speed(rig, friction)) > rig.omega_s
    depth = family_for(rig, friction).grazing_depth(load)
    speed = np.where(bistable, depth / np.asarray(friction.v_b) + rig.omega_s, np.nan)
    return float(speed) if np.ndim(speed) == 0 else np.asarray(speed)


def _followed_to_fold(rig: Rig, friction: Friction) -> Quantity:
    from drillrig_env.stability.end_of_stick_slip import end_of_stick_slip

    end = end_of_stick_slip(rig, friction)
    if np.any(np.asarray(end.kind) == "other"):
        raise ValueError(
            f"fold_speed: under the law {friction.law!r} stick-slip ends at {end.speed} rad/s without a fold, where it "
            "loses its stability; see end_of_stick_slip"
        )
    return end.speed


def load_of(rig: Rig, friction: Friction) -> FloatArray:
    """ln(v_b N_1 r_1 (mu_s - mu_k)) - v_b omega_s, which decides how deep the grazing orbit is.

    Raises `ValueError` for another law than the exponential one, of which the orbits are no family of a rig's.
    """
    if friction.law != "exponential":
        raise refuse("slipping orbits", "law", repr(friction.law), "", "'exponential'")
    drop = np.asarray(friction.normal_force) * rig.r_1 * (np.asarray(friction.mu_s) - friction.mu_k)
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(drop * friction.v_b) - np.asarray(friction.v_b) * rig.omega_s)


def family_for(rig: Rig, friction: Friction) -> SlippingOrbits:
    """The rig's family of slipping orbits, followed deep enough for the largest load of a friction.

    Raises `ValueError` for a load beyond what can be followed, and `FloatingPointError` for a rig of which not even
    the orbits of a light load are found.
    """
    load = float(np.max(load_of(rig, friction)))
    for reach, samples in product(REACHES, (FEW_SAMPLES, MANY_SAMPLES)):
        family = slipping_orbits(rig, reach, samples)
        if load <= family.largest_load:
            return family
        deepest = family.depth[len(family.loads) - 1]
        largest = float(np.exp(family.largest_load + _GROWTH)) * REACHES[-1] / deepest
        is_too_heavy = np.exp(load) > largest and len(family.loads) > 1
        if is_too_heavy or (family.ends and samples == MANY_SAMPLES):
            break
    if not is_too_heavy and family.ends and family.depth[-1] < FIRST_REACH:
        raise FloatingPointError(f"fold_speed: {family.ends}")
    steepest = "the steepest fall of the friction, N_1 r_1 (mu_s - mu_k) v_b"
    allowed = f"< {largest:.3g}" if is_too_heavy else f"<= {float(np.exp(family.largest_load)):.3g}"
    raise refuse("fold_speed", steepest, f"{float(np.exp(load)):.3g}", "N m s/rad", allowed)


def basin_depth(rig: RigLike, friction: FrictionLike, speed_reference: Quantity) -> FloatArray:
    """How far below its mean (rad/s) the bit speed may swing at a speed reference before stick-slip takes over.

    `rig` and `friction` are given as `Rig.of` and `Friction.of` take them; `speed_reference` is in rad/s.

    The swing of the unstable orbit p2, which parts calm rotation from stick-slip: 0 at the critical
    speed and below. Shapes broadcast.

    >>> from drillrig_env import Friction, Rig, stability
    >>> round(float(stability.basin_depth(Rig(), Friction(20.0), 3.5)), 1)  # rad/s
    2.7
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    load = load_of(rig, friction)
    log_gain = load + np.asarray(friction.v_b) * (rig.omega_s - np.asarray(speed_reference))
    return np.asarray(family_for(rig, friction).depth_of_gain(log_gain) / friction.v_b)
