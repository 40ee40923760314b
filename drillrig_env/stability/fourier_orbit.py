"""A slipping orbit in all its states: Fourier series from the wave of the bit speed, and what is measured of them.

Of every harmonic of the bit speed the other states follow from the chain above the bit (`mode_shape`), so that an orbit
is known as exactly as its wave, however shallow it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.model import equilibrium, state_equations
from drillrig_env.rig import Rig
from drillrig_env.stability.impedance import Complex, mode_shape
from drillrig_env.stability.multipliers import multipliers_of, slipping_monodromy
from drillrig_env.stepper.exponentials import RADAU_NODES
from drillrig_env.stepper.units import units_of

_FINER = 8
"""How many times as many samples as the wave has are taken to find extremes and crossings."""


@dataclass(frozen=True, eq=False)
class FourierOrbit:
    """A slipping orbit at a speed reference (rad/s), from its wave q = v_b (x_3 - omega_ref), lowest first.

    `frequency` is in rad/s, `log_gain` is ln G of `drillrig_env.stability.slipping_orbits`; phases run from 0, at the
    lowest bit speed, to 2 pi.
    """

    rig: Rig
    friction: Friction
    speed_reference: float
    wave: FloatArray
    frequency: float
    log_gain: float

    @property
    def period(self) -> float:
        """The period in s."""
        return 2.0 * np.pi / self.frequency

    @cached_property
    def spectrum(self) -> Complex:
        """Complex amplitudes of the states, from the mean on; shape (harmonics, 7)."""
        v_b, m = float(self.friction.v_b), len(self.wave)
        speed = np.fft.rfft(self.wave)[1 : m // 2] * (2.0 / m / v_b)
        shapes = mode_shape(self.rig, np.array(1j * self.frequency * np.arange(1, m // 2)))
        kinetic = float(self.friction.normal_force) * self.rig.r_1 * float(self.friction.mu_k)
        torque = kinetic + float(np.mean(np.exp(self.log_gain - self.wave))) / v_b
        return np.concatenate([equilibrium(self.rig, torque, self.speed_reference)[None], shapes * speed[:, None]])

    def states(self, phase: FloatArray) -> FloatArray:
        """The states at phases (rad); shape (..., 7)."""
        turns = np.exp(1j * np.asarray(phase)[..., None] * np.arange(len(self.spectrum)))
        return np.asarray((turns @ self.spectrum).real)

    @cached_property
    def _samples(self) -> FloatArray:
        count = _FINER * len(self.wave)
        half = np.concatenate([self.spectrum[:1], 0.5 * self.spectrum[1:]])
        return np.asarray(np.fft.irfft(half, count, axis=0) * count)

    def extremes(self, columns: slice) -> tuple[FloatArray, FloatArray]:
        """The lowest and the highest of some states, each the vertex of a parabola through three samples."""
        samples = self._samples[:, columns]
        return -_peaks(-samples), _peaks(samples)

    @cached_property
    def section_phase(self) -> float:
        """The phase (rad) at which the bit speed passes the speed reference, rising."""
        above = int(np.argmax(self._samples[:, 2] > self.speed_reference))
        step = 2.0 * np.pi / len(self._samples)
        phase, _ = brentq(
            lambda phase: self.states(np.array(phase))[2] - self.speed_reference,
            (above - 1) * step,
            above * step,
            xtol=1e-14,
            full_output=True,
        )
        return float(phase)

    def monodromy(self, phase: float) -> FloatArray:
        """The monodromy matrix from a phase (rad) on, as `slipping_monodromy` has it."""
        steps = len(self.wave) // 2
        nodes = phase + 2.0 * np.pi / steps * (np.arange(steps)[:, None] + RADAU_NODES)
        wave = float(self.friction.v_b) * (self.states(nodes)[..., 2] - self.speed_reference)
        return slipping_monodromy(self.rig, self.period, -np.exp(self.log_gain - wave))

    @cached_property
    def multipliers(self) -> npt.NDArray[np.complex128]:
        """The 7 Floquet multipliers, largest first, one of which is 1."""
        state = self.states(np.array(self.section_phase))
        torque = float(self.friction.torque(self.rig, self.speed_reference))
        rates = np.array(state_equations(state, self.speed_reference, torque, self.rig))
        return multipliers_of(self.monodromy(self.section_phase), rates / units_of(self.rig).states)


def _peaks(samples: FloatArray) -> FloatArray:
    """The largest value of each column of periodic samples, between them too."""
    top = np.argmax(samples, axis=0)
    before, at, after = (np.take_along_axis(samples, (top[None] + i) % len(samples), axis=0)[0] for i in (-1, 0, 1))
    bend = before - 2.0 * at + after
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(bend < 0.0, at - (after - before) ** 2 / (8.0 * bend), at))
