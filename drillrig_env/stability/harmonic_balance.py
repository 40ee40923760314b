"""Harmonic balance: a periodic orbit that never sticks as a wave of the bit speed, by Newton's method.

The equations are those of `drillrig_env.stability.slipping_orbits`, q = G L[exp(-q)], at equally spaced samples of one
period; L is a product with the transfer function -1 / Z of every harmonic.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from drillrig_env.arrays import FloatArray
from drillrig_env.rig import Rig
from drillrig_env.stability.impedance import Complex, impedance

_TAIL = 1e-9
"""Largest share of the highest harmonics; above it the number of samples is doubled."""

_CLOSE = 1e-11
"""Newton's method has converged where its step is below this share of the depth, and of Omega and G."""

_FELT = 1e-10
"""The share of the largest friction below which what a step changes of it, where the bit is fast, is not solved for."""


class HarmonicBalance:
    """The equations q = G L[exp(-q)] of a rig at M samples of one period, and Newton's method for them."""

    def __init__(self, rig: Rig, samples: int) -> None:
        self.rig, self.samples = rig, samples
        self.harmonics = np.arange(samples // 2 + 1)
        self.rates = 1j * self.harmonics * (self.harmonics < samples // 2)  # of d/d theta

    def transfer(self, frequency: float) -> tuple[Complex, Complex]:
        """H(i k Omega) = -1 / Z of every harmonic, and its derivative with respect to Omega (rad/s)."""
        response, slope = np.zeros((2, len(self.harmonics)), dtype=complex)
        order: Complex = np.array(1j * self.harmonics[1:])
        Z, derivative = impedance(self.rig, order * frequency)
        response[1:], slope[1:] = -1.0 / Z, order * derivative / Z**2
        response[-1], slope[-1] = response[-1].real, slope[-1].real
        return response, slope

    @np.errstate(all="ignore")  # what runs away is seen, and raised
    def solve(self, depth: float, q: FloatArray, frequency: float, log_gain: float) -> tuple[FloatArray, float, float]:
        """The orbit of a given depth from a guess: q at the samples (lowest first), Omega, ln G.

        Raises `FloatingPointError` where Newton's method does not converge.
        """
        m = self.samples
        derivative = np.fft.irfft(self.rates, m)[(-np.arange(m)) % m]
        for _ in range(25):
            response, slope = self.transfer(frequency)
            spectrum = np.fft.rfft(np.exp(log_gain) * np.expm1(-q))  # a constant makes no difference
            drive = np.exp(log_gain - q)
            answer = np.fft.irfft(response * spectrum, m)
            residual = np.concatenate([q - answer, [q[0] + depth, derivative @ q]])
            if not np.isfinite(residual).all():
                break
            felt = np.flatnonzero(drive > _FELT * drive.max())
            n = len(felt)
            shifted = sliding_window_view(np.tile(np.fft.irfft(response, m), 2), m)[m - felt]
            by_frequency = -np.fft.irfft(slope * spectrum, m) * frequency
            columns = np.vstack([shifted * drive[felt, None], by_frequency, -answer]).T
            matrix = np.vstack([np.eye(n, n + 2) + columns[felt], np.eye(1, n + 2), derivative @ columns])
            known = np.concatenate([-residual[felt], [-residual[m], residual[m + 1] - derivative @ residual[:m]]])
            try:
                solved = np.linalg.solve(matrix, known)
            except np.linalg.LinAlgError:
                break
            step = np.concatenate([-residual[:m] - columns @ solved, solved[n:]])
            q, frequency, log_gain = q + step[:m], frequency * np.exp(step[m]), log_gain + step[m + 1]
            if np.abs(step[:m]).max() < _CLOSE * depth and np.abs(step[m:]).max() < _CLOSE:
                return q, float(frequency), float(log_gain)
        raise FloatingPointError(
            f"harmonic balance: no orbit of depth {depth:g} found with {m} samples; check the rig's parameters"
        )

    def is_resolved(self, q: FloatArray) -> bool:
        """Whether the highest harmonics of q have died out."""
        spectrum = np.abs(np.fft.rfft(q))
        return bool(spectrum[-max(3, self.samples // 16) :].max() < _TAIL * spectrum.max())


@lru_cache(maxsize=32)
def balance_of(rig: Rig, samples: int) -> HarmonicBalance:
    """The equations of a rig, built or recalled."""
    return HarmonicBalance(rig, samples)
