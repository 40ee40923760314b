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
from drillrig_env.model import friction_input, jacobian
from drillrig_env.rig import Rig
from drillrig_env.stability.stable_sets import critical_slope, stable_set

_POINTS_A_UNIT = 12
_FIRST_DEPTH = 0.02
_TAIL = 1e-9
"""Largest share of the highest harmonics; above it the number of samples is doubled."""

_MOST_SAMPLES = 4096
"""Most samples of an orbit; plausible rigs take 64 to 512, and a matrix for twice this many fills 0.5 GB."""

Complex = npt.NDArray[np.complex128]


class HarmonicBalance:
    """The equations q = G L[exp(-q)] of a rig at M samples of one period, and Newton's method for them."""

    def __init__(self, rig: Rig, samples: int) -> None:
        self.samples = samples
        self.harmonics = np.arange(samples // 2 + 1)
        self.rates = 1j * self.harmonics * (self.harmonics < samples // 2)  # of d/d theta
        self._matrix, self._input = jacobian(rig), friction_input(rig)
        poles, modes = np.linalg.eig(self._matrix)
        self._poles = poles
        self._residues = modes[2] * np.linalg.solve(modes, self._input)
        i, j = np.indices((samples, samples))
        self._circulant = (i - j) % samples

    def transfer(self, frequency: float) -> tuple[Complex, Complex]:
        """H(i k Omega) of every harmonic, and its derivative with respect to Omega (rad/s)."""
        s = 1j * self.harmonics * frequency
        distance = s[:, None] - self._poles
        response = (self._residues / distance).sum(axis=1)
        slope = -1j * self.harmonics * (self._residues / distance**2).sum(axis=1)
        response[0] = slope[0] = 0.0
        response[-1], slope[-1] = response[-1].real, slope[-1].real
        return response, slope

    def solve(self, depth: float, q: FloatArray, frequency: float, log_gain: float) -> tuple[FloatArray, float, float]:
        """The orbit of a given depth from a guess: q at the samples (lowest first), Omega, ln G.

        Raises `FloatingPointError` where Newton's method does not converge.
        """
        m = self.samples
        derivative = np.fft.irfft(self.rates, m)[(-np.arange(m)) % m]
        for _ in range(25):
            response, slope = self.transfer(frequency)
            drive = np.exp(log_gain - q)
            spectrum = np.fft.rfft(drive)
            answer = np.fft.irfft(response * spectrum, m)
            residual = np.concatenate([q - answer, [q[0] + depth, derivative @ q]])
            matrix = np.zeros((m + 2, m + 2))
            matrix[:m, :m] = np.eye(m) + np.fft.irfft(response, m)[self._circulant] * drive
            matrix[:m, m] = -np.fft.irfft(slope * spectrum, m)
            matrix[:m, m + 1] = -answer
            matrix[m, 0] = 1.0
            matrix[m + 1, :m] = derivative
            try:
                step = np.linalg.solve(matrix, -residual)
            except np.linalg.LinAlgError:
                break
            q, frequency, log_gain = q + step[:m], frequency + step[m], log_gain + step[m + 1]
            if np.abs(step).max() < 1e-12 * max(1.0, depth):
                return q, float(frequency), float(log_gain)
        raise FloatingPointError(
            f"harmonic balance: no orbit of depth {depth:g} found with {m} samples; check the rig's parameters"
        )

    def is_resolved(self, q: FloatArray) -> bool:
        """Whether the highest harmonics of q have died out."""
        spectrum = np.abs(np.fft.rfft(q))
        return bool(spectrum[-max(3, self.samples // 16) :].max() < _TAIL * spectrum.max())


@dataclass(frozen=True, eq=False)
class SlippingOrbits:
    """The family of a rig: depth a, ln G and frequency Omega (rad/s) of each orbit, and its samples of q."""

    rig: Rig
    depth: FloatArray
    log_gain: FloatArray
    frequency: FloatArray
    waves: tuple[FloatArray, ...]

    @cached_property
    def _depth_of_load(self) -> CubicSpline:
        return CubicSpline(self.log_gain + self.depth, self.depth)

    @cached_property
    def guess(self) -> CubicSpline:
        """The pair ln G, Omega (rad/s) as a spline of the depth."""
        return CubicSpline(self.depth, np.stack([self.log_gain, self.frequency], axis=1))

    def grazing_depth(self, load: FloatArray) -> FloatArray:
        """Depth of the orbit that grazes under a load, ln(v_b N_1 r_1 (mu_s - mu_k)) - v_b omega_s; NaN: none does."""
        loads = self.log_gain + self.depth
        return np.where(load >= loads[0], self._depth_of_load(np.maximum(load, loads[0])), np.nan)

    @cached_property
    def _depth_of_gain(self) -> CubicSpline:
        return CubicSpline(-self.log_gain, self.depth)

    def depth_of_gain(self, log_gain: FloatArray) -> FloatArray:
        """Depth of the orbit p2 at a gain, ln G; 0 where G is above the critical one, and p2 is gone."""
        inside = np.clip(-np.asarray(log_gain), -self.log_gain[0], -self.log_gain[-1])
        return np.asarray(self._depth_of_gain(inside))

    def orbit(self, depth: float) -> tuple[FloatArray, float, float]:
        """The orbit of a depth inside the family: samples of q over one period (lowest first), Omega, ln G."""
        nearest = int(np.argmin(np.abs(self.depth - depth)))
        wave = self.waves[nearest]
        log_gain, frequency = self.guess(depth)
        return _balance(self.rig, len(wave)).solve(depth, wave * (-depth / wave[0]), frequency, log_gain)


@lru_cache(maxsize=32)
def _balance(rig: Rig, samples: int) -> HarmonicBalance:
    return HarmonicBalance(rig, samples)


@lru_cache(maxsize=32)
def slipping_orbits(rig: Rig, largest_depth: float = 12.0) -> SlippingOrbits:
    """Follow the family of a rig from its Hopf point to a depth (12: well past 40 N on the chapter's rig).

    Raises `ValueError` for a rig without a Hopf point, whose Delta T_r,min is not negative or is not there, and
    `FloatingPointError` for one whose orbits cannot be found or resolved.
    """
    slope = critical_slope(rig)
    if slope >= 0:
        raise ValueError(
            "slipping_orbits: under any friction that falls with speed steady rotation of this rig is never stable: "
            "its drive shakes by itself; see stable_slopes"
        )
    samples, log_gain = 64, float(np.log(-slope))
    frequency = stable_set(rig)[0][0].frequency
    depths = np.concatenate([[_FIRST_DEPTH], np.arange(1, round(largest_depth * _POINTS_A_UNIT) + 1) / _POINTS_A_UNIT])
    q = -_FIRST_DEPTH * np.cos(2 * np.pi * np.arange(samples) / samples)
    found: list[tuple[float, float, FloatArray]] = [(log_gain, frequency, np.zeros(samples))]
    for depth in depths:
        q, frequency, log_gain = _balance(rig, samples).solve(depth, q * (-depth / q[0]), frequency, log_gain)
        while not _balance(rig, samples).is_resolved(q):
            if samples >= _MOST_SAMPLES:
                raise FloatingPointError(
                    f"harmonic balance: {samples} samples do not resolve the orbit of depth {depth:g}; "
                    "check the rig's parameters"
                )
            samples *= 2
            finer = np.fft.irfft(np.fft.rfft(q), samples) * 2.0
            q, frequency, log_gain = _balance(rig, samples).solve(depth, finer, frequency, log_gain)
        found.append((log_gain, frequency, q))
    return SlippingOrbits(
        rig,
        np.concatenate([[0.0], depths]),
        np.array([gain for gain, _, _ in found]),
        np.array([omega for _, omega, _ in found]),
        tuple(wave for _, _, wave in found),
    )
