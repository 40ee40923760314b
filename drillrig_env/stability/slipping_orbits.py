"""Periodic orbits that never stick: the unstable branch p2 and the fold, exact by harmonic balance.

While the bit slips, (4-17) is linear but for T_r1(x_3), so that a periodic bit speed of mean omega obeys

    x_3 = omega + L[T_r1(x_3)],

where L multiplies the harmonic k by the rig's transfer function H(i k Omega) from friction torque to bit
speed. The integrator of the drive makes H(0) = 0: the mean is the speed reference, and the constant
part of the friction does not matter. With q = v_b (x_3 - omega) this becomes

    q = G L[exp(-q)],   G = v_b N_1 r_1 (mu_s - mu_k) exp(-v_b omega):

**one family of orbits for every friction of a rig**, with one parameter, the friction's negative slope G
at the speed reference. It begins at the Hopf point, G = |Delta T_r,min|, and is followed here in its
depth a = -min q. An orbit grazes the stick zone, x_3 = omega_s, where a = v_b (omega - omega_s): there
it meets the sticking branch p1, and both end. The fold of any friction is therefore the inverse of one
function of the rig, ln G(a) + a = ln(v_b N_1 r_1 (mu_s - mu_k)) - v_b omega_s.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from drillrig_env.arrays import FloatArray
from drillrig_env.rig import Rig
from drillrig_env.stability.grazing import grazing_multipliers
from drillrig_env.stability.harmonic_balance import balance_of
from drillrig_env.stability.stable_sets import critical_fall, stable_set
from drillrig_env.stepper.limits import check_computable

FIRST_REACH = 12.0
"""Depth to which a family is followed at first: well past 40 N on the chapter's rig."""

FEW_SAMPLES, MANY_SAMPLES = 256, 2048
"""Most samples of an orbit: what plausible rigs take, 64 to 512, and what is tried where these do not do."""

_POINTS_A_UNIT = 12
_POINTS_A_REACH = 60  # beyond FIRST_REACH steps grow with the depth: this many to twice the depth, and some
_FIRST_DEPTH = 0.02

_AHEAD = 5
"""Orbits, at most, of which the next is guessed."""

_EVERY = 5
"""Of every so many orbits it is found out what becomes of stick-slip where they graze."""

_CERTAIN = 0.02
"""How far inside the unit circle multipliers must be there, between which others are interpolated."""


@dataclass(frozen=True, eq=False)
class SlippingOrbits:
    """The family of a rig: depth a, ln G and frequency Omega (rad/s) of each orbit, and its samples of q.

    `ends` says why the family could be followed no further; None where it reaches the depth asked for.
    """

    rig: Rig
    depth: FloatArray
    log_gain: FloatArray
    frequency: FloatArray
    waves: tuple[FloatArray, ...]
    ends: str | None = None

    @cached_property
    def largest_load(self) -> float:
        """The largest load, as for `grazing_depth`, of which the grazing orbit is in this family."""
        return float(self.loads[-1])

    @cached_property
    def loads(self) -> FloatArray:
        """The load under which each orbit grazes, up to where it no longer rises with the depth."""
        loads = self.log_gain + self.depth
        falls = np.flatnonzero(np.diff(loads) <= 0.0)
        return loads[: falls[0] + 1] if len(falls) else loads

    @cached_property
    def _depth_of_load(self) -> CubicSpline:
        return CubicSpline(self.loads, self.depth[: len(self.loads)])

    @cached_property
    def guess(self) -> CubicSpline:
        """The pair ln G, Omega (rad/s) as a spline of the depth."""
        return CubicSpline(self.depth, np.stack([self.log_gain, self.frequency], axis=1))

    def grazing_depth(self, load: FloatArray) -> FloatArray:
        """Depth of the orbit that grazes under a load, ln(v_b N_1 r_1 (mu_s - mu_k)) - v_b omega_s; NaN: none here."""
        least, largest = self.loads[0], self.largest_load
        depth = self._depth_of_load(np.clip(load, least, largest))
        return np.where((load >= least) & (load <= largest), depth, np.nan)

    @cached_property
    def unstable_side(self) -> tuple[FloatArray, FloatArray]:
        """-ln G, rising, and depth from the orbit of the largest gain on: p2 beside stable steady rotation."""
        first = int(np.argmax(self.log_gain))
        gains, depths = -self.log_gain[first:], self.depth[first:]
        rises = np.append(True, np.diff(np.maximum.accumulate(gains)) > 0.0)
        return gains[rises], depths[rises]

    @cached_property
    def _depth_of_gain(self) -> CubicSpline:
        return CubicSpline(*self.unstable_side)

    def depth_of_gain(self, log_gain: FloatArray) -> FloatArray:
        """Depth of the unstable orbit p2 at a gain, ln G; that of the largest gain where G is above it.

        That one is 0 where p2 begins unstable: at the critical gain it is gone.
        """
        gains, _ = self.unstable_side
        return np.asarray(self._depth_of_gain(np.clip(-np.asarray(log_gain), gains[0], gains[-1])))

    @cached_property
    def _at_grazing(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Depths, and what `grazing_multipliers` says of the orbits there."""
        chosen = np.unique(np.append(np.arange(1, len(self.depth), _EVERY), len(self.depth) - 1))
        found = [
            grazing_multipliers(self.rig, self.waves[i], self.frequency[i], self.log_gain[i]) for i in chosen if i > 0
        ]
        products, radii = np.array(found).reshape(-1, 2).T
        return self.depth[chosen[chosen > 0]], products, radii

    def ends_stick_slip(self, depth: FloatArray) -> npt.NDArray[np.bool_]:
        """Whether an orbit of a depth is for certain the end of stable stick-slip where it grazes (see `grazing`)."""
        depths, products, radii = self._at_grazing
        product, radius = np.interp(depth, depths, products), np.interp(depth, depths, radii)
        return np.asarray((product < 0.0) & (radius < 1.0 - _CERTAIN))

    def orbit(self, depth: float) -> tuple[FloatArray, float, float]:
        """The orbit of a depth inside the family: samples of q over one period (lowest first), Omega, ln G."""
        nearest = max(int(np.argmin(np.abs(self.depth - depth))), 1)
        wave = self.waves[nearest]
        log_gain, frequency = self.guess(depth)
        return balance_of(self.rig, len(wave)).solve(depth, wave * (-depth / wave[0]), frequency, log_gain)


@lru_cache(maxsize=64)
def slipping_orbits(rig: Rig, reach: float = FIRST_REACH, most_samples: int = FEW_SAMPLES) -> SlippingOrbits:
    """Follow the family of a rig from its Hopf point to a depth, as far as it can be found and resolved.

    Raises `ValueError` for a rig beyond what can be computed and for one without a Hopf point, whose Delta T_r,min is
    not negative or is not there, and `FloatingPointError` for one of which not even the first orbit is found or
    resolved with MANY_SAMPLES.
    """
    if most_samples > FEW_SAMPLES:
        begun = slipping_orbits(rig, reach)
    elif reach > FIRST_REACH:
        begun = slipping_orbits(rig, 0.5 * reach)
    else:
        begun = _hopf_point(rig)
    depths, gains, frequencies = list(begun.depth), list(begun.log_gain), list(begun.frequency)
    waves, ends = list(begun.waves), None
    small = -np.cos(2.0 * np.pi * np.arange(len(waves[0])) / len(waves[0]))
    shapes = [small, *(wave / depth for wave, depth in zip(waves[1:], depths[1:], strict=True))]
    orbits = [np.append(orbit, shape) for *orbit, shape in zip(frequencies, gains, shapes, strict=True)]
    if begun.ends and most_samples <= FEW_SAMPLES:
        return begun
    for depth in _depths(depths[-1], reach):
        try:
            frequency, log_gain, *shape = _ahead(depth, depths, orbits)
            wave, frequency, log_gain = _resolved(
                rig, depth, depth * np.array(shape), frequency, log_gain, most_samples
            )
        except FloatingPointError as error:
            if len(depths) == 1 and most_samples == MANY_SAMPLES:
                raise
            ends = str(error)
            break
        found = (depth, log_gain, frequency, wave, np.append([frequency, log_gain], wave / depth))
        for kept, value in zip((depths, gains, frequencies, waves, orbits), found, strict=True):
            kept.append(value)
    return SlippingOrbits(rig, np.array(depths), np.array(gains), np.array(frequencies), tuple(waves), ends)


def _hopf_point(rig: Rig) -> SlippingOrbits:
    """The family's beginning alone: the orbit of depth 0, with the form of a small one."""
    check_computable(rig)
    slope = critical_fall(rig, "slipping_orbits")
    frequency = next(low.frequency for low, _ in stable_set(rig) if low.slope == slope)
    zeros = np.zeros(64)
    return SlippingOrbits(rig, np.zeros(1), np.array([np.log(-slope)]), np.array([frequency]), (zeros,))


def _ahead(depth: float, depths: list[float], orbits: list[FloatArray]) -> FloatArray:
    """A guess at the next orbit: the polynomial through the last few that have as many samples."""
    last = [i for i in range(max(1, len(depths) - _AHEAD), len(depths)) if len(orbits[i]) == len(orbits[-1])]
    if len(last) < 2:
        return orbits[-1]
    at, unit = np.array(depths)[last], np.eye(len(last))
    weights = np.prod((depth - at - unit * (depth - at - 1.0)) / (at[:, None] - at + unit), axis=1)
    return np.asarray(weights @ np.array([orbits[i] for i in last]))


def _depths(last: float, reach: float) -> FloatArray:
    """Depths from the last one on, up to `reach`."""
    within = np.arange(1, round(min(reach, FIRST_REACH) * _POINTS_A_UNIT) + 1) / _POINTS_A_UNIT
    doublings = max(np.log2(reach / FIRST_REACH), 0.0)
    beyond = FIRST_REACH * 2.0 ** (np.arange(1, round(doublings * _POINTS_A_REACH) + 1) / _POINTS_A_REACH)
    depths = np.concatenate([[_FIRST_DEPTH], within, beyond])
    return depths[depths > last * (1.0 + 1e-12)]


def _resolved(
    rig: Rig, depth: float, wave: FloatArray, frequency: float, log_gain: float, most_samples: int
) -> tuple[FloatArray, float, float]:
    """The orbit of a depth from a guess, with as many samples as it takes."""
    samples = len(wave)
    while True:
        wave, frequency, log_gain = balance_of(rig, samples).solve(depth, wave, frequency, log_gain)
        if balance_of(rig, samples).is_resolved(wave):
            return wave, frequency, log_gain
        if samples >= most_samples:
            raise FloatingPointError(
                f"harmonic balance: {samples} samples do not resolve the orbit of depth {depth:g}; "
                "check the rig's parameters"
            )
        samples *= 2
        wave = np.fft.irfft(np.fft.rfft(wave), samples) * 2.0
