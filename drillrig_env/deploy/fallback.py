"""What turns the rig in a fault: the target, or Z-torque while its own measurement can be trusted."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from drillrig_env.deploy.checks import last_number
from drillrig_env.deploy.controller import Controller
from drillrig_env.parameters import refuse

TORQUE = "string_torque"
"""What Z-torque goes by."""


class Fallback:
    """The law of `Limits.fallback` beside a `controller`: "constant", "z_torque", or a file of that.

    Raises `ValueError` for another law, or one of another control period.
    """

    def __init__(self, law: str, controller: Controller) -> None:
        self.law = None if law == "constant" else _z_torque(law, controller)
        self.channels = () if self.law is None else (TORQUE,)
        self._runs = False

    def rest(self) -> None:
        """Begin anew when it is asked the next time."""
        self._runs = False

    def step(self, measurements: Mapping[str, Any], faults: Collection[str], reference: float, target: float) -> float:
        """The speed reference (rad/s) that it wants, from the one that there is to a target (rad/s)."""
        torque = last_number(measurements.get(TORQUE))
        if self.law is None or torque is None or TORQUE in faults:
            self._runs = False
            return target
        shown = {**dict.fromkeys(self.law.channels, 0.0), TORQUE: torque}  # the law reads the torque alone
        if not self._runs:
            self.law.start(reference, target, shown)
            self._runs = True
        self.law.target = target
        return self.law.step(shown, reference=reference)


def _z_torque(policy: str, controller: Controller) -> Controller:
    law = Controller(policy)
    if law.file.about["training"].get("law") != "ZTorque":
        raise refuse("Limits", "fallback", repr(policy), "", "constant, z_torque, or a file of z_torque")
    if law.period != controller.period:
        allowed = f"{controller.period:g}, that of {controller.name}"
        raise refuse("Limits", "control period of the fallback", law.period, "s", allowed)
    return law
