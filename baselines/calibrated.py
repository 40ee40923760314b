"""A law for rigs each of which has been calibrated: designed anew on what the records of each told."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from baselines.told import LQGOfRig
from drillrig_env.arrays import FloatArray
from drillrig_env.fleet import Fleet, FleetLike
from drillrig_env.friction import Friction
from drillrig_env.parameters import refuse

__all__ = ["LQGCalibrated"]


class LQGCalibrated(LQGOfRig):
    """`LQGOfRig` on the rigs and laws of friction that were `found`; told only which rig it is at.

    `found` has a rig for each that an episode may have, in the same order, with what a calibration of that one found:
    nothing in it is of the rig itself, and at one rig it is a controller that anybody can make there. `fleet` has the
    rigs as they are, and is not designed for. `ValueError` where nothing was found, or not of as many rigs.
    """

    privileged: ClassVar[tuple[str, ...]] = ("rig",)

    def __init__(self, *given: Any, found: FleetLike = None, fleet: FleetLike = None, **others: Any) -> None:
        calibrated, played = Fleet.of(found), Fleet.of(fleet)
        if calibrated is None:
            raise ValueError(
                "LQGCalibrated: found is missing; allowed: a Fleet of the rigs as calibrated, one for each that is "
                "played, as python -m benchmarks.calibrated_rigs makes it"
            )
        super().__init__(*given, fleet=calibrated, **others)
        members = calibrated.members(self.rig)
        if played is not None and (count := len(played.members(self.rig))) != len(members):
            raise refuse("LQGCalibrated", "rigs found", len(members), "", f"{count}, one for each of the fleet")
        _, mu_s, mu_k, v_b = self.nominal_friction.as_array()[0]
        factors = members.friction
        self._coefficients = np.stack(
            [mu_k * factors[:, 0] + (mu_s - mu_k) * factors[:, 1], mu_k * factors[:, 0], v_b * factors[:, 2]]
        )

    def _law(self, privileged: Mapping[str, FloatArray]) -> Friction:
        return Friction(1.0, *self._coefficients[:, self.places(privileged)], law=self.nominal_friction.law)
