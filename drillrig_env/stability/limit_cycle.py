"""One periodic orbit: the stick-slip orbit p1 by shooting, the unstable orbit p2 by harmonic balance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction, FrictionLike
from drillrig_env.model import friction_input, frictionless_state, jacobian, wound_up
from drillrig_env.parameters import POSITIVE, refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.stability.fold import family_for, fold_speed, load_of
from drillrig_env.stability.hurwitz import critical_speed
from drillrig_env.stability.return_map import flow, next_crossings
from drillrig_env.stepper.batch import advance_batch

SIGNALS = ("bit_speed", "collar_speed", "top_speed", "current")
"""The states whose extremes an orbit reports, columns 2 to 5 of the state."""

_FREE = [0, 1, 3, 4, 5, 6]  # the states that vary on the section x_3 = omega_ref
_SAMPLE_PERIOD = 1e-3  # s, for extremes: a peak is met within 1e-5 rad/s
_SETTLING_RETURNS = 12
_NEWTON_LIMIT = 15
_CLOSED = 1e-7
"""An orbit counts as closed when it returns within this (in every state's own unit)."""

_DIFFERENCE = {"p1": 1e-4, "p2": 1e-6}
"""Steps of finite differences, for speed references of 1 rad/s and more; in proportion below. p1 meets
kinks, each with an error near 1e-8; p2 is smooth but near the fold must not be pushed into the stick zone."""


class NoOrbitError(ValueError):
    """There is no such periodic orbit; the message says why and where there is one."""


@dataclass(frozen=True, eq=False)
class PeriodicOrbit:
    """A periodic orbit of a rig at a speed reference (rad/s).

    `state` is its point on the section x_3 = omega_ref, with the bit speeding up. `lowest` and
    `highest` hold the extremes of SIGNALS (rad/s, A), `stuck` the share of the period within the
    stick zone, `multipliers` the 7 Floquet multipliers, largest first, one of which is 1.
    """

    rig: Rig
    friction: Friction
    branch: Literal["p1", "p2"]
    speed_reference: float
    period: float  # s
    state: FloatArray
    lowest: FloatArray
    highest: FloatArray
    stuck: float
    multipliers: npt.NDArray[np.complex128]

    @property
    def stable(self) -> bool:
        """Whether every multiplier but the trivial one lies inside the unit circle."""
        trivial = int(np.argmin(np.abs(self.multipliers - 1.0)))
        return bool(np.all(np.abs(np.delete(self.multipliers, trivial)) < 1.0))

    def trajectory(self, samples: int = 400) -> tuple[FloatArray, FloatArray]:
        """Times (s) over one period and the states there, shapes (samples + 1,) and (samples + 1, 7)."""
        step = self.period / samples
        parts = int(np.ceil(step / 0.05))
        states = advance_batch(
            self.rig,
            self.friction,
            self.state[None],
            self.speed_reference,
            period=step / parts,
            periods=samples * parts,
            every=parts,
        )
        return step * np.arange(samples + 1, dtype=float), np.concatenate([self.state[None], states[0]])


def stick_slip_orbit(
    rig: RigLike, friction: FrictionLike, speed_reference: float, guess: FloatArray | None = None
) -> PeriodicOrbit:
    """The stick-slip orbit p1, by shooting on the fast stepper; `guess` is a state near its section point.

    Raises `NoOrbitError` where the rig does not stick and slip, `ValueError` for a speed reference
    that is not positive.
    """
    rig, friction = Rig.of(rig), Friction.of(friction).single()
    _check_speed(speed_reference)
    x = wound_up(rig, friction, speed_reference).reshape(1, 7) if guess is None else np.array(guess, dtype=float)[None]
    for _ in range(1 if guess is not None else _SETTLING_RETURNS):
        x, times = next_crossings(rig, friction, speed_reference, x)
        if np.isnan(times[0]):
            raise _no_stick_slip(rig, friction, speed_reference)
    for _ in range(_NEWTON_LIMIT):
        image, times = next_crossings(rig, friction, speed_reference, x)
        gap = (image - x)[0, _FREE]
        if np.isnan(times[0]):
            raise _no_stick_slip(rig, friction, speed_reference)
        if np.abs(gap).max() < _CLOSED:
            break
        x[0, _FREE] += np.linalg.solve(np.eye(6) - _return_slopes(rig, friction, speed_reference, x[0]), gap)
    else:
        raise _no_stick_slip(rig, friction, speed_reference)
    orbit = _describe(rig, friction, "p1", speed_reference, float(times[0]), x[0])
    if orbit.stuck == 0.0:
        raise _no_stick_slip(rig, friction, speed_reference)
    return orbit


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
    v_b = float(friction.v_b)
    speed_reference = rig.omega_s + (float(load_of(rig, friction)) - log_gain) / v_b
    drive = np.fft.rfft(np.exp(log_gain - q)) / v_b  # the part of T_r1 that varies, N m
    harmonics = 1j * frequency * np.arange(len(drive))
    systems = harmonics[:, None, None] * np.eye(7) - jacobian(rig)
    states = np.fft.irfft(np.linalg.solve(systems, friction_input(rig)[:, None])[..., 0].T * drive, len(q)).T
    kinetic = float(friction.normal_force) * rig.r_1 * float(friction.mu_k)
    rest = np.linalg.solve(jacobian(rig), -friction_input(rig) * kinetic)
    lowest = frictionless_state(rig, speed_reference) + rest + states[0]
    state, _ = next_crossings(rig, friction, speed_reference, lowest[None])
    return _describe(rig, friction, "p2", speed_reference, 2 * np.pi / frequency, state[0])


def _describe(
    rig: Rig, friction: Friction, branch: Literal["p1", "p2"], speed_reference: float, period: float, state: FloatArray
) -> PeriodicOrbit:
    samples = advance_batch(
        rig, friction, state[None], speed_reference, period=_SAMPLE_PERIOD, periods=int(period / _SAMPLE_PERIOD)
    )[0]
    return PeriodicOrbit(
        rig,
        friction,
        branch,
        speed_reference,
        period,
        state,
        lowest=samples[:, 2:6].min(axis=0),
        highest=samples[:, 2:6].max(axis=0),
        stuck=float(np.mean(np.abs(samples[:, 2]) < rig.omega_s)),
        multipliers=_multipliers(rig, friction, branch, speed_reference, state, period),
    )


def _multipliers(
    rig: Rig, friction: Friction, branch: str, speed_reference: float, state: FloatArray, period: float
) -> npt.NDArray[np.complex128]:
    """Eigenvalues of the flow's derivative over one period, by central differences; largest first."""
    size = _DIFFERENCE[branch] * min(1.0, speed_reference)
    steps = size * np.eye(7)
    ends = flow(rig, friction, speed_reference, np.concatenate([state + steps, state - steps]), period)
    values = np.linalg.eigvals((ends[:7] - ends[7:]).T / (2 * size)).astype(complex)
    return values[np.argsort(-np.abs(values))]


def _return_slopes(rig: Rig, friction: Friction, speed_reference: float, state: FloatArray) -> FloatArray:
    """Derivative of the return map on the section, by central differences; shape (6, 6)."""
    size = _DIFFERENCE["p1"] * min(1.0, speed_reference)
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
