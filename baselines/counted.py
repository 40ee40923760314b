"""Laws whose numbers are those of the chapter's rig, on any rig: they see it counted in scales of its own.

A law with gains, times and speeds of the chapter's rig holds for every rig of another size that moves like it. So
the rig, what is seen and what is told are handed over counted in the rig's scales (`drillrig_env.scales`), in which
the rig is about as large as the chapter's, and the speed reference that the law wants is turned back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from math import exp
from typing import Any

import numpy as np
import numpy.typing as npt

from baselines.baseline import Baseline
from drillrig_env.arrays import FloatArray
from drillrig_env.env.sensors import CHANNELS
from drillrig_env.friction import Friction
from drillrig_env.parameters import refuse
from drillrig_env.rig import Rig, RigLike
from drillrig_env.scales import CONTROL_PERIOD

_CHAPTERS_LAW = Friction().law
_UNITS = {channel.name: channel.unit for channel in CHANNELS} | {
    item.name: item.metadata["unit"] for item in fields(Friction)
}
"""Units of what is seen and told."""


class CountedLaw(Baseline):
    """A policy whose law, and every number given to it, counts in the rig's own scales; on the chapter's rig SI units.

    `desired_reference` gets `seen` and `privileged` so, and returns a speed reference of that kind, at most
    `drillrig_env.scales.LARGEST_REFERENCE`; beside it there are `plant`, the rig counted so, `period`, the length of a
    control step, and `plant_slew`, the slew limit. `plants` are the rigs of the fleet, counted so, where the policy is
    told which of them an episode has, and the one rig else. `nominal_friction` is the one that it goes by, counted so,
    at N_1 = 1. Arguments as for `Baseline`.

    >>> from baselines import ZTorque
    >>> from drillrig_env import Rig
    >>> slow = Rig(J_1=0.1152, k_2=0.1829)
    >>> issubclass(ZTorque, CountedLaw), ZTorque(rig=slow).gain == ZTorque().gain
    (True, True)
    """

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        scales = self.task.scales
        self.plant: Rig = scales.counted
        fleet = self.fleet if "rig" in self.privileged else None
        rigs = (self.rig,) if fleet is None else fleet.members(self.rig).rigs
        self.plants = tuple(scales.count(rig) for rig in rigs)
        units = {name: scales.units[unit] for name, unit in _UNITS.items()}
        self._units = {name: unit for name, unit in units.items() if unit != 1.0}
        self._rate, self._time = scales.rate, scales.time
        self.nominal_friction = Friction(1.0)
        if (friction := self.friction) is not None:
            v_b = np.asarray(friction.v_b) / self.unit("v_b")
            self.nominal_friction = replace(friction, normal_force=1.0, v_b=v_b)

    @property
    def period(self) -> float:
        """Length of a control step, counted in the rig's scale of times."""
        return self.task.control_period / self._time

    @property
    def plant_slew(self) -> float:
        """Largest rate of the speed reference, counted in the rig's scales."""
        return self.slew_limit / self._rate

    def places(self, privileged: Mapping[str, FloatArray]) -> npt.NDArray[np.intp]:
        """Which of `plants` each episode has, shape (n,); (1,) where nothing is told, and there is the one.

        `privileged` has what is told, by name, shape (n,) each.

        `ValueError` for a rig that is not of the fleet.
        """
        if "rig" not in privileged:
            return np.zeros(1, dtype=np.intp)
        places = privileged["rig"].astype(np.intp)
        if places.max() >= len(self.plants):
            allowed = f"0 to {len(self.plants) - 1}, the fleet that it was made for"
            raise refuse(type(self).__name__, "rig", int(places.max()), "", allowed)
        return places

    def check_chapters_law(self) -> None:
        """Raise `ValueError` where the nominal friction falls by another law than the chapter's.

        It is for policies that plan with that one.
        """
        if self.nominal_friction.law != _CHAPTERS_LAW:
            law = self.nominal_friction.law
            raise refuse(type(self).__name__, "law of the friction", repr(law), "", repr(_CHAPTERS_LAW))

    def unit(self, name: str) -> float:
        """What a channel, or an entry of `info`, is counted in. `name` is that of either."""
        return self._units.get(name, 1.0)

    def followed(self, time_constant: float) -> float:
        """Share that a mean with a time constant follows in a control step.

        `time_constant` is in s, as on the chapter's rig.
        """
        return 1.0 - exp(-self.period / time_constant)

    def each_step(self, share: float) -> float:
        """What is followed in a control step, where `share` is in one of the length that the rig's scales give."""
        steps = self.period / CONTROL_PERIOD
        return share if abs(steps - 1.0) < 1e-9 else 1.0 - (1.0 - share) ** steps

    def _desired(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        return self.desired_reference(self._counted(seen), self._counted(privileged), memory) * self.unit("bit_speed")

    def _counted(self, values: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
        if not self._units:
            return values
        return {name: value / self.unit(name) for name, value in values.items()}
