"""Hyperparameters of trainings that take a second: few rigs, short rollouts, nothing imitated first."""

from typing import Any

_SHORT: dict[str, Any] = {"imitation": None, "critic_iterations": 0, "frame_stack": 1}
PPO: dict[str, Any] = {**_SHORT, "n_envs": 8, "n_steps": 16, "batch_size": 64, "n_epochs": 1}
SAC: dict[str, Any] = {**_SHORT, "n_envs": 4, "learning_starts": 100, "batch_size": 32, "gradient_steps": 1}
ASYMMETRIC: dict[str, Any] = {
    **_SHORT,
    "n_envs": 8,
    "n_steps": 10,
    "batch_size": 40,
    "policy_kwargs": {"lstm_hidden_size": 8, "enable_critic_lstm": False, "net_arch": {"pi": [8], "vf": []}},
}

FEW: dict[str, Any] = {"rigs": {"spread": {"string": 2.0, "friction": 1.5}, "count": 3, "seed": 0}, "spread": 0.0}
"""Draws of three rigs that nobody knows."""

SHORT: dict[str, Any] = {"duration": 4.0, "threads": 1, "scenario": FEW}
"""Of `DrillRigUnknown-v0`: episodes of 40 steps on them."""
