"""The environments by id, and their registration with Gymnasium."""

from __future__ import annotations

from typing import Any

import gymnasium as gym

ENVIRONMENTS: dict[str, dict[str, Any]] = {
    "DrillRig-v0": {"sensors": "state"},
    "DrillRigSurface-v0": {"sensors": "surface"},
}
"""The registered environments, and the arguments in which they differ."""


def register_envs() -> None:
    """Register the environments with Gymnasium; calling it again changes nothing."""
    for name, kwargs in ENVIRONMENTS.items():
        if name not in gym.registry:
            gym.register(
                name,
                entry_point="drillrig_env.env.single:DrillRigEnv",
                vector_entry_point="drillrig_env.env.vector:DrillRigVectorEnv",
                kwargs=kwargs,
            )
