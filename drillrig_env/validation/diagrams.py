"""Section 4.4.3: the branches p1 and p2, the fold and the bistable range of figures 4.12 and 4.13."""

from __future__ import annotations

import numpy as np

from drillrig_env.friction import Friction
from drillrig_env.model import steady_state, wound_up
from drillrig_env.rig import Rig
from drillrig_env.stability import (
    NoOrbitError,
    critical_speed,
    fold_speed,
    is_stable,
    slipping_orbit,
    stick_slip_orbit,
)
from drillrig_env.validation.check import Check, claim, number
from drillrig_env.validation.ending import Ending, ending

BETWEEN = 2.4  # rad/s; inside the bistable range at 10 N


def checks() -> list[Check]:
    """All checks of this module."""
    rig = Rig()
    return [*fold(rig), *branches(rig), *regions(rig)]


def fold(rig: Rig) -> list[Check]:
    """Where p1 ends, and how wide the bistable range is."""
    light, heavy = Friction(10.0), Friction(20.0)
    folds = [float(fold_speed(rig, friction)) for friction in (light, heavy)]
    widths = [end - float(critical_speed(rig, f)) for end, f in zip(folds, (light, heavy), strict=True)]
    last = stick_slip_orbit(rig, light, folds[0] - 1e-3)
    return [
        number(
            "figure 4.12",
            "p1 and p2 meet (fold) at 10 N",
            2.9,
            folds[0],
            "rad/s",
            tolerance=0.005,
            decimals=4,
            remark="the end of the stick-slip branch; it took part in identifying the motor",
        ),
        claim(
            "figure 4.12",
            "the stick-slip branch p1 ends there",
            f"0.001 rad/s below the fold p1 sticks for {100 * last.stuck:.1f} % of its period; "
            "0.001 rad/s above it there is no orbit",
            last.stuck > 0 and not _sticks_and_slips(rig, light, folds[0] + 1e-3),
            "the orbit ends where it grazes the stick zone",
        ),
        claim(
            "figure 4.13",
            "the bistable range is wider at 20 N than at 10 N",
            f"{widths[0]:.4f} rad/s at 10 N, {widths[1]:.4f} rad/s at 20 N (up to {folds[1]:.4f} rad/s)",
            widths[1] > widths[0],
        ),
    ]


def branches(rig: Rig) -> list[Check]:
    """Stability of p1 and p2 by their Floquet multipliers."""
    friction = Friction(10.0)
    border, end = float(critical_speed(rig, friction)), float(fold_speed(rig, friction))
    sticking = stick_slip_orbit(rig, friction, BETWEEN)
    small, middle, large = (
        slipping_orbit(rig, friction, border + share * (end - border)) for share in (0.01, 0.5, 0.99)
    )
    unstable = [float(np.abs(orbit.multipliers).max()) for orbit in (small, middle, large)]
    second = np.sort(np.abs(sticking.multipliers))[-2]
    return [
        claim(
            "figure 4.12",
            "the periodic branch p1 is stable",
            f"second largest Floquet multiplier at 10 N, {BETWEEN:g} rad/s: {second:.3f} (the largest, 1, is trivial)",
            sticking.stable,
        ),
        claim(
            "figure 4.12",
            "the periodic branch p2 is unstable",
            "largest Floquet multiplier "
            + ", ".join(f"{value:.3f}" for value in unstable)
            + f" at {small.speed_reference:.3f}, {middle.speed_reference:.3f}, {large.speed_reference:.3f} rad/s",
            not any(orbit.stable for orbit in (small, middle, large)),
        ),
        claim(
            "figure 4.12",
            "p2 leads from the fold to H2, where it vanishes",
            "bit speed of p2 between "
            + ", ".join(f"{o.lowest[0]:.2f} and {o.highest[0]:.2f}" for o in (large, middle, small))
            + " rad/s at the same speeds, from the highest down",
            np.ptp([small.lowest[0], small.highest[0]]) < 0.2 * np.ptp([large.lowest[0], large.highest[0]]),
        ),
    ]


def regions(rig: Rig) -> list[Check]:
    """Which solutions there are below omega_c, between omega_c and the fold, and above it, at 10 N."""
    friction = Friction(10.0)
    below, above = 1.5, 2.95
    pushed = _from_steady(rig, friction, below)
    calm, wound = _from_steady(rig, friction, BETWEEN), _from_stuck(rig, friction, BETWEEN)
    freed = _from_stuck(rig, friction, above)
    return [
        claim(
            "figure 4.12",
            "below omega_c only the periodic solution is stable",
            f"{below:g} rad/s, 10 N, from next to steady rotation: {pushed}",
            pushed.sticks and not is_stable(rig, friction, below) and not _has_slipping_orbit(rig, friction, below),
            "nor is there an unstable orbit p2",
        ),
        claim(
            "figure 4.12",
            "between omega_c and the fold the perturbation decides which of two solutions is met",
            f"{BETWEEN:g} rad/s, 10 N, from next to steady rotation: {calm}; from a stuck, wound-up rig: {wound}",
            calm.calm and wound.sticks,
        ),
        claim(
            "figure 4.12",
            "above the fold only the equilibrium is left",
            f"{above:g} rad/s, 10 N, from a stuck, wound-up rig: {freed}",
            freed.calm and not _sticks_and_slips(rig, friction, above),
        ),
    ]


def _from_steady(rig: Rig, friction: Friction, speed: float) -> Ending:
    nudge = 0.01 * np.eye(7)[2]  # rad/s on the bit
    return ending(rig, friction, steady_state(rig, friction, speed) + nudge, speed)


def _from_stuck(rig: Rig, friction: Friction, speed: float) -> Ending:
    return ending(rig, friction, wound_up(rig, friction, speed), speed)


def _sticks_and_slips(rig: Rig, friction: Friction, speed: float) -> bool:
    try:
        stick_slip_orbit(rig, friction, speed)
    except NoOrbitError:
        return False
    return True


def _has_slipping_orbit(rig: Rig, friction: Friction, speed: float) -> bool:
    try:
        slipping_orbit(rig, friction, speed)
    except NoOrbitError:
        return False
    return True
