"""What the ablations train: PPO's setting on the softened drive, and the same with one choice changed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from agents.policy.environment import environment_arguments
from agents.training.hyperparameters import HYPERPARAMETER_FILES, hyperparameters
from agents.training.settings import Training
from drillrig_env.env.sensors import Sensors

SETTING = HYPERPARAMETER_FILES / "soft_drive" / "ppo.yml"
"""The setting that is changed."""

STATISTICS = ("bit_speed_mean", "bit_speed_deviation", "string_torque_mean", "string_torque_deviation")
"""Channels that are running statistics rather than measurements of the moment."""


@dataclass(frozen=True)
class Variant:
    """One setting: `reward`, `env_kwargs` and `hyperparams` are put into the shipped one.

    `without` lists channels that are left out, `absolute_action` chooses the action of `agents.policy.absolute_action`.
    """

    name: str
    words: str
    env_id: str = "DrillRig-v0"
    reward: Mapping[str, Any] = field(default_factory=dict)
    env_kwargs: Mapping[str, Any] = field(default_factory=dict)
    hyperparams: Mapping[str, Any] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    absolute_action: bool = False

    def training(self, seed: int, steps: int, changes: Mapping[str, Any] | None = None) -> Training:
        """The training of one seed; `changes` are hyperparameters that all variants get."""
        shipped = hyperparameters("ppo", self.env_id, file=SETTING).get("env_kwargs", {})
        env_kwargs: dict[str, Any] = dict(self.env_kwargs)
        if self.reward:
            env_kwargs["reward"] = {**shipped.get("reward", {}), **self.reward}
        if self.without:
            shown = Sensors.named(environment_arguments(self.env_id, shipped)["sensors"])
            env_kwargs["sensors"] = [name for name in shown.names if name not in self.without]
            env_kwargs.setdefault("noise", shipped.get("noise", shown.noise))
            env_kwargs.setdefault("delay", shipped.get("delay", shown.delay))
        hyperparams = {**(changes or {}), **self.hyperparams}
        return Training("ppo", self.env_id, seed, steps, hyperparams, env_kwargs, SETTING, eval_freq=-1)


_SURFACE = "DrillRigSurface-v0"

VARIANTS = (
    Variant("shipped", "the setting of the softened drive"),
    Variant(
        "squares",
        "reward of squares: variance and squared error in place of deviation and absolute error",
        reward={"variance_shape": "square", "tracking_shape": "square"},
    ),
    Variant(
        "large_rewards",
        "rewards ten times as large",
        reward={"variance": 1.0, "tracking": 2.0, "action": 0.03},
    ),
    Variant(
        "absolute_action",
        "absolute action: ω_ref = ω* + 2 a rad/s, reached at the slew limit, in place of the rate",
        absolute_action=True,
    ),
    Variant(
        "no_statistics",
        "no running statistics of bit speed and torque among the observations",
        without=STATISTICS,
    ),
    Variant("stiff_drive", "the rig's own stiff drive in place of the soft one", env_kwargs={"drive": None}),
    Variant("surface", "the setting of the softened drive", _SURFACE),
    Variant("surface_no_history", "no history: one step of measurements", _SURFACE, hyperparams={"frame_stack": 1}),
    Variant(
        "surface_no_statistics",
        "no running statistics of the torque among the observations",
        _SURFACE,
        without=STATISTICS,
    ),
    Variant(
        "uniform_targets",
        "targets drawn uniformly, not more often slow ones",
        env_kwargs={"scenario": "default"},
    ),
)
"""Every variant, each environment's shipped setting before its changes."""
