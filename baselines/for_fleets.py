"""Laws for rigs that nobody knows and rigs that drift: tuned on such, or told the motor.

A law that is tuned on one rig leans on it. These are the same laws with what `python -m baselines.tune NAME --suites
unknown --sensors surface` found on a fleet of its own (`drillrig_env.seeds.TUNING_FLEETS`), or with `--suites drift`
on the nominal rig as it drifts, for the sensors of the surface. They compete where they are asked for: `drillrig
evaluate baselines/for_fleets.py:LQGOfFleet --suite unknown`.
"""

from __future__ import annotations

from typing import Any, ClassVar

from baselines.baseline import Baseline
from baselines.lqg import LQG
from baselines.soft_torque import SoftTorque
from baselines.tuned import tuned_values
from baselines.z_torque import ZTorque


class ZTorqueOfFleet(ZTorque):
    """`ZTorque`, tuned on a fleet; told nothing."""

    tuned_values: ClassVar[dict[str, dict[str, float]]] = tuned_values("z_torque_fleet")


class LQGOfFleet(LQG):
    """`LQG`, tuned on a fleet; told nothing. Its model stays that of the nominal rig."""

    tuned_values: ClassVar[dict[str, dict[str, float]]] = tuned_values("lqg_fleet")


class ZTorqueOfDrift(ZTorque):
    """`ZTorque`, tuned on the nominal rig as it drifts; told nothing."""

    tuned_values: ClassVar[dict[str, dict[str, float]]] = tuned_values("z_torque_drift")


class SoftTorqueOfFleet(SoftTorque):
    """`SoftTorque`, tuned on a fleet, with the share of the nameplate's back-EMF that it makes up for; told nothing.

    Where it makes up for all of it and the motor has less, the drive is negatively damped.
    """

    tuned: ClassVar[dict[str, tuple[float, float]]] = {**SoftTorque.tuned, "back_emf_share": (0.5, 1.0)}
    tuned_values: ClassVar[dict[str, dict[str, float]]] = tuned_values("soft_torque_fleet")

    def __init__(self, *given: Any, back_emf_share: float | None = None, **others: Any) -> None:
        super().__init__(*given, **others)
        self.back_emf_share = self._given_or_tuned(back_emf_share=back_emf_share)["back_emf_share"]


class SoftTorqueOfMotor(SoftTorque):
    """`SoftTorque` with a drive that knows its motor's back-EMF constant, whatever the nameplate says."""

    def __init__(self, *given: Any, **others: Any) -> None:
        super().__init__(*given, **{"back_emf": "motor", **others})


OF_FLEETS: dict[str, type[Baseline]] = {
    "z_torque_fleet": ZTorqueOfFleet,
    "lqg_fleet": LQGOfFleet,
    "soft_torque_fleet": SoftTorqueOfFleet,
    "z_torque_drift": ZTorqueOfDrift,
}
"""What was tuned on a fleet, or on a rig that drifts, by its name in the record of tuning."""
