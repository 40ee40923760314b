"""Z-torque: give way to the torque as a string that goes on for ever would, and nothing comes back."""

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

_SQUARE = MEMORY + OSCILLATION_MEMORY  # column of memory: mean square amplitude of the torque's oscillation
LIFT_TIME = 5.0  # s, of that mean; about two cycles


class ZTorque(CountedLaw):
    """omega_ref = omega* - T / Z + a lift while it shakes, with T = T_s - LP(T_s); told nothing.

    Impedance matching at the top (Dwars, SPE/IADC-173037, 2015): a torsional wave that comes up finds the
    top giving way like more string, and is not sent back. `gain` is 1/Z, rad/s per N m; `time_constant`
    that of the low-pass LP, s. Refinements, all from what is seen:

    - T is followed at the string's lowest mode (`baselines.string_torque.oscillation` with `follow`) and
      turned on by `lead` (s), back where it is negative: it sets the phase that the filters, the drive and
      late sensors leave;
    - `lift` (rad/s per N m) raises the speed with the running amplitude of T, as far as that is above what
      calm rotation may show, `calm` of the target at the bit. The slew limit keeps the law from giving way
      enough at a high load; at more speed the friction falls less, and once the torque is calm the lift
      is gone.

    A long LP keeps the reference off its target long after a step of the load: two seconds serve both.
    Works from any sensors that show the torque's change. Tuned by `python -m baselines.tune z_torque
    --sensors state` and `--sensors surface` on training seeds: noise forbids a gain that serves the state.
    """

    any_of = TORQUE_SHOWN
    memory = _SQUARE + 1
    tuned: ClassVar[dict[str, tuple[float, float]]] = {
        "gain": (2.0, 12.0),
        "time_constant": (1.0, 10.0),
        "lead": (-0.15, 0.25),
        "follow": (0.2, 1.0),
        "lift": (0.0, 8.0),
    }
    tuned_values: ClassVar[dict[str, dict[str, float]]] = tuned_values("z_torque")

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        gain: float | None = None,
        time_constant: float | None = None,
        lead: float | None = None,
        follow: float | None = None,
        lift: float | None = None,
        calm: float = 0.1,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        values = self._given_or_tuned(gain=gain, time_constant=time_constant, lead=lead, follow=follow, lift=lift)
        self.gain = values["gain"]
        self.time_constant = values["time_constant"]
        self.lead = values["lead"]
        self.follow = values["follow"]
        self.lift = values["lift"]
        self.calm = calm
        check_filters("ZTorque", self.time_constant, self.follow)

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The target, less what the torque asks the top to give way, plus the lift."""
        deviation = torque_deviation(self.plant, seen, memory[:, :MEMORY], self.time_constant, self.period)
        z = oscillation(self.plant, deviation, memory[:, MEMORY:_SQUARE], self.each_step(self.follow), self.period)
        ahead = z * np.exp(2j * pi * self.plant.string_frequencies[0] * self.lead)
        memory[:, _SQUARE] += self.period / LIFT_TIME * (np.abs(z) ** 2 - memory[:, _SQUARE])
        calm = self.calm * self.plant.impedance * seen["speed_target"]
        excess = np.maximum(np.sqrt(memory[:, _SQUARE]) - calm, 0.0)
        return np.asarray(seen["speed_target"] - self.gain * ahead.real + self.lift * excess)
