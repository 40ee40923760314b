"""A law for rigs each of which has been calibrated: designed anew on what the records of each told."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from baselines.told import LQGOfRig
from drillrig_env.arrays import FloatArray
from drillrig_env.friction import Friction

__all__ = ["LQGCalibrated"]


class LQGCalibrated(LQGOfRig):
    """`LQGOfRig` on rigs and laws of friction as a `fleet` of the policy's own has them; told only which rig it is at.

    The fleet has a rig for each that an episode may have, in the same order, with what a calibration of that one
    found: nothing in it is of the rig itself, and at one rig it is a controller that anybody can make there.
    """

    privileged: ClassVar[tuple[str, ...]] = ("rig",)

    def __init__(self, *given: Any, **others: Any) -> None:
        super().__init__(*given, **others)
        factors = np.ones((1, 3)) if self.fleet is None else self.fleet.members(self.rig).friction
        _, mu_s, mu_k, v_b = self.nominal_friction.as_array()[0]
        self._coefficients = np.stack(
            [mu_k * factors[:, 0] + (mu_s - mu_k) * factors[:, 1], mu_k * factors[:, 0], v_b * factors[:, 2]]
        )

    def _law(self, privileged: Mapping[str, FloatArray]) -> Friction:
        return Friction(1.0, *self._coefficients[:, self.places(privileged)], law=self.nominal_friction.law)
