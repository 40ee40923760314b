"""The stiff drive of the chapter: hold the speed reference at the target and hope."""

from __future__ import annotations

from collections.abc import Mapping

from baselines.baseline import Baseline
from drillrig_env.arrays import FloatArray


class Constant(Baseline):
    """omega_ref = omega*. What a drive does that nobody touches; frees a rig only past its fold."""

    def desired_reference(
        self, seen: Mapping[str, FloatArray], privileged: Mapping[str, FloatArray], memory: FloatArray
    ) -> FloatArray:
        """The target itself."""
        return seen["speed_target"]
