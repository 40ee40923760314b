"""Speed pulse: answer an oscillation with one planned pulse that makes the opposite one, and then wait."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Any, ClassVar

import numpy as np

from baselines.counted import CountedLaw
from baselines.string_torque import (
    MEMORY,
    OSCILLATION_MEMORY,
    TORQUE_SHOWN,
    check_filters,
    oscillation,
    torque_deviation,
)
from baselines.tuned import tuned_values
from drillrig_env.arrays import FloatArray
from drillrig_env.rig import RigLike

_TIME, _HEIGHT = MEMORY + OSCILLATION_MEMORY, MEMORY + OSCILLATION_MEMORY + 1  # columns of memory
_MEAN_TIME = 5.0  # s, of the torque's mean: about two cycles, so that a step of the load is soon forgotten


class SpeedPulse(CountedLaw):
    """An open-loop pulse on the reference, timed to the torque's phase (Kyllingstad, WO 2013/112056); told nothing.

    The torque's deviation is followed at the string's lowest mode (`baselines.string_torque.oscillation`
    with `follow`), which gives amplitude and phase. Where amplitude / Z, the swing of the bit, is above
    `shaking` times the target, a pulse begins when the phase reaches `phase` (in cycles; 0 is the torque's
    peak). It raises the reference by `strength` times the amplitude for `length` cycles, as fast as the
    slew limit lets it. The next may begin `pause` cycles after its end. Between pulses omega_ref = omega*.

    Works from any sensors that show the torque's change. Tuned by `python -m baselines.tune speed_pulse
    --sensors state --budget 180` and `--sensors surface --budget 180` on training seeds.
    """

    any_of = TORQUE_SHOWN
    memory = MEMORY + OSCILLATION_MEMORY + 2  # the torque; time since the pulse began, s; its height, rad/s
    tuned: ClassVar[dict[str, tuple[float, float]]] = {
        "strength": (2.0, 8.0),
        "phase": (0.05, 0.45),
        "length": (0.2, 0.8),
        "pause": (0.0, 1.5),
        "follow": (0.1, 0.4),
    }
    tuned_values: ClassVar[dict[str, dict[str, float]]] = tuned_values("speed_pulse")

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        strength: float | None = None,
        phase: float | None = None,
        length: float | None = None,
        pause: float | None = None,
        follow: float | None = None,
        shaking: float = 0.1,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        values = self._given_or_tuned(strength=strength, phase=phase, length=length, pause=pause, follow=follow)
        self.strength = values["strength"]
        self.phase = values["phase"]
        self.length = values["length"]
        self.pause = values["pause"]
        self.follow = values["follow"]
        self.shaking = shaking
        check_filters("SpeedPulse", _MEAN_TIME, self.follow)

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The target, and on top of it the pulse that is under way."""
        frequency = self.plant.string_frequencies[0]
        target = seen["speed_target"]
        amplitude, due = self._listen(seen, memory, frequency)
        young = memory[:, 0] * self.period < 1.0 / frequency  # less than a cycle heard
        busy = (memory[:, _HEIGHT] > 0) & (memory[:, _TIME] < (self.length + self.pause) / frequency)
        begins = due & ~busy & ~young & (amplitude / self.plant.impedance > self.shaking * target)
        memory[:, _HEIGHT] = np.where(begins, self.strength * amplitude, memory[:, _HEIGHT])
        memory[:, _TIME] = np.where(begins, 0.0, memory[:, _TIME] + self.period)
        return target + np.where(memory[:, _TIME] < self.length / frequency, memory[:, _HEIGHT], 0.0)

    def _listen(
        self, seen: Mapping[str, FloatArray], memory: FloatArray, frequency: float
    ) -> tuple[FloatArray, np.ndarray]:
        """Amplitude of the torque at the mode (N m), and whether its phase passes `phase` in this step."""
        deviation = torque_deviation(self.plant, seen, memory[:, :MEMORY], _MEAN_TIME, self.period)
        z = oscillation(self.plant, deviation, memory[:, MEMORY:_TIME], self.each_step(self.follow), self.period)
        past = np.mod(np.angle(z) - 2.0 * pi * self.phase, 2.0 * pi)
        return np.abs(z), past < 1.5 * 2.0 * pi * frequency * self.period
