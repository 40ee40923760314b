"""The environments by id, and their registration with Gymnasium."""

from __future__ import annotations

from collections.abc import Collection
from types import FrameType
from typing import Any

import gymnasium as gym

from drillrig_env.seeds import TRAINING_FLEETS

UNKNOWN = {"string": 2.0, "inertias": 2.0, "friction": 2.0, "motor": 1.1}
"""Factors within which a rig is unknown; see `drillrig_env.fleet.Fleet`."""

ENVIRONMENTS: dict[str, dict[str, Any]] = {
    "DrillRig-v0": {"sensors": "state"},
    "DrillRigSurface-v0": {"sensors": "surface"},
    "DrillRigUnknown-v0": {
        "sensors": "surface",
        "delay": (1, 2),
        "scenario": {"spread": 0.0, "rigs": {"spread": UNKNOWN, "seed": TRAINING_FLEETS.start}},
    },
    "DrillRigDrift-v0": {"sensors": "surface", "delay": (1, 2), "scenario": "drift"},
}
"""The registered environments, and the arguments in which they differ."""


def register_envs() -> None:
    """Register the environments with Gymnasium; calling it again changes nothing.

    >>> import gymnasium as gym
    >>> from drillrig_env import register_envs
    >>> register_envs()
    >>> "DrillRig-v0" in gym.registry
    True
    """
    for name, kwargs in ENVIRONMENTS.items():
        if name not in gym.registry:
            gym.register(
                name,
                entry_point="drillrig_env.env.single:DrillRigEnv",
                vector_entry_point="drillrig_env.env.vector:DrillRigVectorEnv",
                kwargs=kwargs,
            )


def check_length(duration: float, steps: int, maker: FrameType | None) -> None:
    """Raise `ValueError` where Gymnasium makes an environment of another length than it was asked for.

    `gym.make(spec, duration=...)` and `make_vec` end episodes after the spec's `max_episode_steps`, whatever the
    duration (s, of `steps` control steps) that is given anew, and say so to nobody. So this looks into the call that
    gives an environment its spec, `maker`.
    """
    said = {} if maker is None else maker.f_locals
    given, limit = said.get("kwargs", {}), getattr(said.get("env_spec"), "max_episode_steps", None)
    task, asked = given.get("task") or (), said.get("max_episode_steps", given.get("max_episode_steps"))
    anew = "duration" in given or "duration" in (task if isinstance(task, Collection) else ("duration",))
    if anew and asked is None and limit not in (None, steps):
        raise ValueError(
            f"DrillRig: duration = {duration:g} s is not allowed with a spec that ends episodes after {limit} steps; "
            f"allowed: with max_episode_steps={steps} beside it, or with the id in place of the spec"
        )
