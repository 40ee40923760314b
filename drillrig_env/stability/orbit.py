"""A periodic orbit as a record, and what is measured of it on the fast stepper: extremes, stick phase, multipliers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction
from drillrig_env.rig import Rig
from drillrig_env.stability.return_map import Passage
from drillrig_env.stepper.batch import advance_batch
from drillrig_env.stepper.units import units_of

SIGNALS = ("bit_speed", "collar_speed", "top_speed", "current")
SIGNAL_COLUMNS = slice(2, 6)
"""The states whose extremes an orbit reports, and their columns of the state."""

_SAMPLE_PERIOD = 1e-3  # s, for extremes: a peak is met within 1e-5 rad/s
_FINE = 100  # times as many samples around the lowest bit speed, where none of the others is in the stick zone

_ROUNDING = 1e-11
"""A multiplier nearer to the unit circle counts as on it: those of an orbit with a swing of 1e-6 are."""


@dataclass(frozen=True, eq=False)
class PeriodicOrbit:
    """A periodic orbit of a rig at a speed reference (rad/s).

    `rig` under `friction` at `speed_reference` has it; `branch` is p1, which sticks, or p2, which does not; `period` is
    in s.

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
        """Whether every multiplier but the trivial one lies inside the unit circle, by more than rounding."""
        trivial = int(np.argmin(np.abs(self.multipliers - 1.0)))
        return bool(np.all(np.abs(np.delete(self.multipliers, trivial)) < 1.0 - _ROUNDING))

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


def describe_orbit(rig: Rig, friction: Friction, speed_reference: float, passage: Passage) -> PeriodicOrbit:
    """The stick-slip orbit p1 whose return to the section is a `passage`.

    Raises `ValueError` where disc 2 does not keep turning against T_r2.
    """
    period, state = passage.time, passage.state
    step = _SAMPLE_PERIOD * units_of(rig).time
    samples = _samples(rig, friction, speed_reference, state, step, int(period / step))
    if rig.T_r2 > 0.0 and samples[:, 3].min() < rig.omega_s:
        raise ValueError(
            f"orbit: disc 2 slows down to its stick zone, so that T_r2 = {rig.T_r2:g} N m is not constant along it; "
            "allowed: T_r2 = 0 N m, or an orbit on which disc 2 keeps turning forwards"
        )
    stuck = float(np.mean(np.abs(samples[:, 2]) < rig.omega_s))
    if stuck == 0.0:
        before = samples[max(int(np.argmin(samples[:, 2])) - 1, 0)]
        closely = _samples(rig, friction, speed_reference, before, step / _FINE, 2 * _FINE)
        stuck = float(np.mean(np.abs(closely[:, 2]) < rig.omega_s)) * 2 * step / period
    return PeriodicOrbit(
        rig,
        friction,
        "p1",
        speed_reference,
        period,
        state,
        lowest=samples[:, SIGNAL_COLUMNS].min(axis=0),
        highest=samples[:, SIGNAL_COLUMNS].max(axis=0),
        stuck=stuck,
        multipliers=passage.multipliers,
    )


def _samples(
    rig: Rig, friction: Friction, speed_reference: float, state: FloatArray, period: float, count: int
) -> FloatArray:
    """States of shape (count, 7) that follow a state, every `period` (s)."""
    states = advance_batch(rig, friction, state[None], speed_reference, period=period, periods=count)
    return np.asarray(states[0])
