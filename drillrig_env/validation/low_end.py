"""Standstill and the Hopf point H1: (4-15), and what the drive's integrator makes of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drillrig_env.friction import Friction
from drillrig_env.model import minimum_speed
from drillrig_env.rig import Rig
from drillrig_env.simulation import simulate
from drillrig_env.stability import eigenvalues, hopf_points, stick_slip_orbit
from drillrig_env.validation.check import Check, claim

NO_INTEGRATOR = 1e-5
"""k_i (V/rad) small enough to add nothing in an hour; 0 would leave the model without a steady state."""

_LEVELS = 0.9 + 0.0005 * np.arange(300)  # of omega_min; slow, since twisting the shafts takes top speed
_HOLD = 10.0  # s a level


def checks() -> list[Check]:
    """All checks of this module."""
    rig = Rig()
    return [*standstill(rig), *first_hopf_point(rig)]


def standstill(rig: Rig) -> list[Check]:
    """omega_min with and without the integrator."""
    light, heavy = (Friction(force) for force in (10.0, 20.0))
    speeds = [float(minimum_speed(rig, friction)) for friction in (light, heavy)]
    loose = [_breaks_loose_at(rig, friction) for friction in (light, heavy)]
    slow = 0.05
    run = simulate(rig, light, speed_reference=slow, duration=120.0)
    moving = run.bit_speed > rig.omega_s
    orbit = stick_slip_orbit(rig, light, slow)
    return [
        claim(
            "(4-15), figure 4.13",
            "omega_min changes with N_1 (its values are not printed)",
            f"{speeds[0]:.4f} rad/s at 10 N, {speeds[1]:.4f} rad/s at 20 N",
            speeds[1] > speeds[0],
            "they rest on the identified motor",
        ),
        claim(
            "(4-15)",
            "a drive without integrator leaves the rig still for omega_ref <= omega_min",
            "speed reference raised slowly, k_i near 0: the bit leaves the stick zone at "
            f"{loose[0]:.4f} omega_min (10 N) and {loose[1]:.4f} omega_min (20 N)",
            all(1.0 <= share < 1.02 for share in loose),
            "later by what the bit's creep in the stick zone of (4-9) takes",
        ),
        claim(
            "figures 4.9, 4.12",
            "for omega_ref < omega_min standstill is a stable equilibrium of (4-17)",
            f"at {slow:g} rad/s, 10 N, from rest: breaks loose after {run.time[np.argmax(moving)]:.1f} s; "
            f"then stick-slip with peaks of {orbit.highest[0]:.3f} rad/s",
            not bool(moving.any()),
            "(4-15) leaves the integrator out, but (4-17) has it: it winds up until the bit breaks loose, so "
            "standstill is no equilibrium for any positive speed reference",
        ),
    ]


def first_hopf_point(rig: Rig) -> list[Check]:
    """H1 on the regularised law (4-9), and the beginning of p1."""
    light, heavy = Friction(10.0), Friction(20.0)
    point = {hopf.label: hopf for hopf in hopf_points(rig, light)}["H1"]
    slopes, growth = zip(
        *(
            (float(light.slope(rig, speed)), eigenvalues(rig, light, speed)[0].real)
            for speed in (0.999 * rig.omega_s, 1.001 * rig.omega_s)
        ),
        strict=True,
    )
    slowest = [stick_slip_orbit(rig, light, speed) for speed in (0.0011, 0.002, 0.01)]
    hard = stick_slip_orbit(rig, heavy, 0.01)
    along = [stick_slip_orbit(rig, light, speed) for speed in (0.01, 0.1, 1.0, 2.0, 2.8)]
    return [
        claim(
            "figure 4.12",
            "equilibrium changes its stability at omega_min, at the Hopf point H1",
            f"at omega_s = {point.speed_reference:g} rad/s: friction slope {slopes[0]:+.1f} just below, "
            f"{slopes[1]:+.4f} N m s/rad just above; largest real part {growth[0]:+.5f} and {growth[1]:+.3f} 1/s",
            bool(np.isclose(point.speed_reference, float(minimum_speed(rig, light)), rtol=0.05)),
            "with the integrator H1 moves from omega_min to omega_s, where the law has a kink",
        ),
        claim(
            "figure 4.12",
            "H1 is a supercritical Hopf point",
            "p1 at 0.0011, 0.002, 0.01 rad/s: peaks "
            + ", ".join(f"{orbit.highest[0]:.2g}" for orbit in slowest)
            + " rad/s, periods "
            + ", ".join(f"{orbit.period:.1f}" for orbit in slowest)
            + f" s (10 N); at 20 N and 0.01 rad/s {hard.highest[0]:.3f} rad/s, {hard.period:.1f} s",
            point.criticality == "supercritical",
            "no pair crosses: real parts jump. A stable orbit does begin there, but with a finite peak (some "
            "3 omega_s at 10 N) and a period that grows without bound towards it, not with amplitude 0",
        ),
        claim(
            "figure 4.12",
            "a stable periodic branch p1 rises from H1",
            "stable at 0.01, 0.1, 1, 2, 2.8 rad/s (10 N), peaks "
            + ", ".join(f"{orbit.highest[0]:.3f}" for orbit in along)
            + " rad/s",
            all(orbit.stable for orbit in along) and bool(np.all(np.diff([o.highest[0] for o in along]) > 0)),
        ),
    ]


def _breaks_loose_at(rig: Rig, friction: Friction) -> float:
    """Share of omega_min at which a drive without integrator first moves the bit out of the stick zone."""
    proportional = replace(rig, k_i=NO_INTEGRATOR)
    least = float(minimum_speed(proportional, friction))
    ramp = [(_HOLD * i, float(least * level)) for i, level in enumerate(_LEVELS)]
    run = simulate(proportional, friction, np.zeros(7), ramp, _HOLD * len(ramp), sample_period=0.5)
    moving = run.bit_speed > rig.omega_s
    return float(run.speed_reference[np.argmax(moving)] / least) if moving.any() else np.inf
