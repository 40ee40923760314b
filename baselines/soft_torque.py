"""Soft torque: the drive's own speed loop made soft, so that the top gives way to the string's waves.

A stiff drive reflects torsional waves; one whose speed gives way in proportion to the torque takes
their energy out. Soft torque does it with the gains of the speed loop, without a torque sensor.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from baselines.counted import CountedLaw
from baselines.tuned import tuned_values
from drillrig_env.arrays import FloatArray
from drillrig_env.drive import Drive
from drillrig_env.parameters import POSITIVE, refuse
from drillrig_env.rig import RigLike


class SoftTorque(CountedLaw):
    """omega_ref = omega*, and a drive whose gains make it a damper of the string's impedance; told nothing.

    Slower than the armature, the drive puts the torque K_p (omega_ref - x_5) + K_i x_7 into the shaft, with
    K_p = eta K_T k_p / R + eta^2 C_m (N m s/rad) and K_i = eta K_T k_i / R (N m/rad), once it makes up for
    the back-EMF, which alone would be 1.66 N m s/rad. `proportional` and `integral` are these two. Matching
    says K_p of the order of the string's impedance Z and K_i = (2 pi f)^2 J_3 with f the string's lowest
    mode (Jansen and van den Steen, J. Sound Vib. 179 (1995) 647): 0.126 and 0.173 on the chapter's rig.

    It makes up for all of the back-EMF (`back_emf_share`) that the motor's nameplate tells; with `back_emf="motor"`
    for that of the very motor, which is another on the rigs of a fleet.

    Needs a drive whose gains can be set. Tuned by `python -m baselines.tune soft_torque` on training seeds.
    """

    tuned: ClassVar[dict[str, tuple[float, float]]] = {"proportional": (0.05, 0.6), "integral": (0.01, 0.5)}
    tuned_values: ClassVar[dict[str, dict[str, float]]] = tuned_values("soft_torque")

    def __init__(
        self,
        sensors: str | tuple[str, ...] = "state",
        rig: RigLike = None,
        slew_limit: float | None = None,
        proportional: float | None = None,
        integral: float | None = None,
        back_emf_share: float = 1.0,
        back_emf: str = "nameplate",
        **others: Any,
    ) -> None:
        super().__init__(sensors, rig, slew_limit, **others)
        values = self._given_or_tuned(proportional=proportional, integral=integral)
        self.back_emf_share, self.back_emf = back_emf_share, back_emf
        self.proportional = values["proportional"]
        self.integral = values["integral"]
        least = self.plant.eta**2 * self.plant.C_m
        if not (np.isfinite(self.proportional) and self.proportional >= least):
            raise refuse(
                "SoftTorque", "proportional", self.proportional, "N m s/rad", f">= {least:.3g}, the motor's own"
            )
        if not POSITIVE.holds(self.integral):
            raise refuse("SoftTorque", "integral", self.integral, "N m/rad", POSITIVE)

    @property
    def drive(self) -> Drive:
        """The drive that has these two, and makes up for the back-EMF."""
        rig, volt = self.plant, self.unit("voltage")
        volts_per_torque = rig.R / (rig.eta * rig.K_T)
        return Drive(
            k_p=(self.proportional - rig.eta**2 * rig.C_m) * volts_per_torque * (volt / self.unit("bit_speed")),
            k_i=self.integral * volts_per_torque * (volt / self.unit("twist_23")),
            back_emf_share=self.back_emf_share,
            back_emf=self.back_emf,
        )

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The target itself: the drive does the rest."""
        return seen["speed_target"]
