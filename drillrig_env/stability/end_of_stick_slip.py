"""The end of stick-slip: the speed reference above which no stable stick-slip orbit is left, and how it ends there.

At moderate loads the branch p1 ends where it grazes, at `fold_speed`. At heavy loads, and under friction that falls
fast, it goes on beyond that speed and turns back in a fold of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import ceil

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray, Quantity
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stability.continuation import SHORTEST_STEP, end_of_branch
from drillrig_env.stability.fold import REACHES, load_of
from drillrig_env.stability.return_map import ReturnMap, speed_gained
from drillrig_env.stability.shooting import find_stick_slip, settled_stick_slip
from drillrig_env.stability.slipping_orbits import SlippingOrbits, slipping_orbits
from drillrig_env.stability.stable_sets import critical_speed
from drillrig_env.stepper.units import units_of

_BELOW = 0.98
"""Where the branch is taken up, as a share of the speed at which it grazes."""

_FIRST_TRY, _TRIES = 0.3, 5
"""Without such a speed: the first share of the speed that a rig gains breaking loose, and tries, each at half."""

_FASTEST = 1e3
"""Speed that a rig may gain breaking loose, in its own unit: faster, the shortest steps miss the stick zone's edge."""

_ABOVE, _BRANCHES = 1.02, 5
"""Where another branch is looked for above the end of one, and branches that are followed at most."""

_STEP = 1.0
"""Of the depth: where it is tried out whether stick-slip ends at grazing. Where it does not, it is over several."""

_AT_GRAZING = 1e-5
"""Share of the speed within which an end is that at grazing: there the stick zone, though narrow, bends the branch."""

_THIN = 5e-3
"""v_b omega_s as a share of the depth up to which the stick zone, when it bends the branch, moves its end by 1e-4."""

_NARROW = 1e-2
"""v_b omega_s up to which friction hardly falls within the stick zone: where nothing slips unstably, nothing sticks."""


@dataclass(frozen=True, eq=False)
class EndOfStickSlip:
    """Where stick-slip ends: at a speed reference (rad/s), and how.

    `kind` is "grazing" where the orbit no longer reaches the stick zone, at `fold_speed`; "fold" where it meets an
    unstable stick-slip orbit above that speed; "other" where it only loses its stability; "none", with NaN as `speed`,
    where there is no stick-slip. Below the end stick-slip may have doubled its period, as it does at heavy loads: there
    p1 itself is unstable. Under another law than the exponential one, of which the grazing orbit is not known,
    it is "fold" also where the orbit turns back within a millionth of it. Both have one entry a rig for a batch of
    frictions.
    """

    speed: Quantity
    kind: str | npt.NDArray[np.str_]


def end_of_stick_slip(rig: RigLike, friction: FrictionLike) -> EndOfStickSlip:
    """The speed reference above which only calm rotation is left, and how stick-slip ends there.

    Raises `ValueError` for a rig of which steady rotation is never stable under friction that falls, and for a load so
    heavy that stick-slip is not found or cannot be followed; `FloatingPointError` for a rig of which no slipping orbit
    is found.

    >>> from drillrig_env import Friction, Rig, stability
    >>> round(float(stability.end_of_stick_slip(Rig(), Friction(10.0)).speed), 2)  # rad/s
    2.9
    """
    rig, friction = Rig.of(rig), Friction.of(friction)
    _check_load(rig, friction)
    if friction.law != "exponential":
        return _of_other_law(rig, friction)
    load, v_b = load_of(rig, friction), np.asarray(friction.v_b)
    family = _family(rig, float(np.max(load)))
    depth = family.grazing_depth(load)
    slips, is_narrow = np.asarray(critical_speed(rig, friction)) > rig.omega_s, v_b * rig.omega_s < _NARROW
    may_graze = slips & is_narrow & (v_b * rig.omega_s < _THIN * depth)
    deepest = float(np.max(depth, where=may_graze, initial=0.0))
    grazes = np.asarray(may_graze & (depth <= _certain_depth(rig, family, ceil(deepest / _STEP))))
    speed, kind = np.where(grazes, depth / v_b + rig.omega_s, np.nan), np.where(grazes, "grazing", "none").astype("U7")
    is_open = ~grazes & (slips | ~is_narrow)
    if np.any(is_open):
        known = np.where(slips, depth, np.nan)
        speed, kind = _with_followed(rig, friction, family, speed, kind, is_open, known)
    return EndOfStickSlip(speed, kind) if np.ndim(load) else EndOfStickSlip(float(speed), str(kind))


def _check_load(rig: Rig, friction: Friction) -> None:
    """Raise `ValueError` for a load with which the bit is too fast for where it sticks to be resolved."""
    gained = speed_gained(rig, friction)
    heaviest = int(np.argmax(gained))
    largest = _FASTEST * units_of(rig).speed
    if gained[heaviest] > largest:
        force = float(friction.as_array()[heaviest, 0])
        raise ValueError(
            f"end_of_stick_slip: N_1 = {force:g} N is not allowed: breaking loose, the bit gains {gained[heaviest]:.3g}"
            f" rad/s, too much to follow it; allowed: <= {force * largest / gained[heaviest]:.4g} N"
        )


def _with_followed(
    rig: Rig,
    friction: Friction,
    family: SlippingOrbits,
    speed: FloatArray,
    kind: npt.NDArray[np.str_],
    is_open: npt.NDArray[np.bool_],
    depth: FloatArray,
) -> tuple[FloatArray, npt.NDArray[np.str_]]:
    """Speeds and kinds with those of open ends, each found by following its branch; `depth` NaN: no grazing orbit."""
    frictions, speeds, kinds = friction.each(), np.atleast_1d(speed), np.atleast_1d(kind)
    depths = np.atleast_1d(depth)
    for i in np.flatnonzero(is_open):
        one = frictions[i]
        fold, may_graze = depths[i] / one.v_b + rig.omega_s, bool(family.ends_stick_slip(depths[i]))
        speeds[i], kinds[i] = _checked(rig, one, _followed(rig, one, float(fold), may_graze))
    return speeds.reshape(speed.shape), kinds.reshape(kind.shape)


def _of_other_law(rig: Rig, friction: Friction) -> EndOfStickSlip:
    """The end of each friction's branch, followed from breaking loose on: no family of orbits says where it grazes."""
    found = [_checked(rig, one, _followed(rig, one, np.nan, False)) for one in friction.each()]
    if np.ndim(friction.break_loose(rig)) == 0:
        return EndOfStickSlip(*found[0])
    return EndOfStickSlip(np.array([speed for speed, _ in found]), np.array([kind for _, kind in found]))


def _checked(rig: Rig, friction: Friction, found: tuple[float, str]) -> tuple[float, str]:
    """What was found by following a branch. Raises `ValueError` where that led to no end."""
    if found[1] == "lost" or (found[1] == "none" and critical_speed(rig, friction) > rig.omega_s):
        raise ValueError(
            f"end_of_stick_slip: N_1 = {friction.normal_force} N is not allowed; "
            "allowed: a load under which stick-slip is found and can be followed to its end"
        )
    return found


def _family(rig: Rig, load: float) -> SlippingOrbits:
    """The family of slipping orbits, up to a load or to where p1 no longer ends at grazing."""
    for reach in REACHES:
        family = slipping_orbits(rig, reach)
        if load <= family.largest_load or family.ends or not family.ends_stick_slip(family.depth[-1]):
            break
    if len(family.depth) == 1:
        raise FloatingPointError(f"end_of_stick_slip: {family.ends}")
    return family


@lru_cache(maxsize=256)
def _certain_depth(rig: Rig, family: SlippingOrbits, steps: int) -> float:
    """The depth, at most `steps` times `_STEP`, up to which stick-slip ends where it grazes, for a narrow stick zone.

    That it may end there, `grazing` says; that no other part of the branch, and no other branch, reaches higher speeds
    is found out at every step.
    """
    certain = 0.0
    for depth in np.minimum(_STEP * np.arange(1, steps + 1), family.depth[-1]).tolist():
        if not family.ends_stick_slip(family.depth[family.depth <= depth]).all():
            break
        v_b = 1.0 / units_of(rig).speed
        fold = depth / v_b + rig.omega_s
        drop = float(np.exp(family.guess(depth)[0] + depth + v_b * rig.omega_s)) / v_b
        friction = Friction(drop / rig.r_1, 2.0, 1.0, v_b)
        if _followed(rig, friction, fold, True) != (fold, "grazing"):
            break
        certain = depth
    return certain


@lru_cache(maxsize=4096)
def _followed(rig: Rig, friction: Friction, fold: float, may_graze: bool) -> tuple[float, str]:
    """The end of the branch of one friction, from below the `fold` (rad/s; NaN: unknown) or from breaking loose on.

    Where stable stick-slip may end at grazing (`may_graze`), it goes on up to there, if no further.
    """
    returns = ReturnMap(rig, friction)
    first = _BELOW * fold if np.isfinite(fold) else _FIRST_TRY * float(speed_gained(rig, friction)[0])
    found: tuple[float, str] = (fold, "grazing") if may_graze and np.isfinite(fold) else (np.nan, "none")
    for halved in range(_TRIES):
        speed_reference = first / 2**halved
        orbit = find_stick_slip(returns, speed_reference) if speed_reference > rig.omega_s else None
        if orbit is not None:
            break
    shortest_step = 0.01 * _AT_GRAZING if may_graze else SHORTEST_STEP
    for _ in range(_BRANCHES):
        if orbit is None:
            break
        end, kind = end_of_branch(returns, speed_reference, orbit, shortest_step)
        is_at_grazing = end < fold * (1.0 + _AT_GRAZING) and (may_graze or kind == "grazing")
        found = (fold, "grazing") if is_at_grazing else (end, kind)
        speed_reference = _ABOVE * found[0]
        orbit = settled_stick_slip(returns, speed_reference)
    return found
