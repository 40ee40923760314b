"""Hyperparameters: read from rl-zoo3's YAML format, changed from the command line, and checked."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm

from agents.training.schedules import policy_kwargs, schedule
from drillrig_env.extras import missing
from drillrig_env.parameters import closest

ALGORITHMS = ("ppo", "sac", "ppo_lstm")
"""The algorithms by the name that the command line takes, as in rl-zoo3."""

HYPERPARAMETER_FILES = Path(__file__).parents[1] / "hyperparams"
"""The folder with one file for each algorithm, `<algorithm>.yml`, with a section for each environment."""

_OURS = ("n_envs", "n_timesteps", "env_kwargs", "frame_stack")  # used by training itself, not by the algorithm
_FIXED = ("self", "env", "seed", "tensorboard_log", "verbose", "_init_setup_model", "device")
_COUNTS = ("n_envs", "n_timesteps", "frame_stack")
_SCHEDULES = ("learning_rate", "clip_range", "clip_range_vf")


def algorithm_class(algorithm: str) -> type[BaseAlgorithm]:
    """The algorithm of that name. `ValueError` for an unknown one, `ImportError` where its package is missing."""
    if algorithm not in ALGORITHMS:
        raise ValueError(f"algorithm {algorithm!r} is not known; {closest(algorithm, ALGORITHMS)}")
    if algorithm != "ppo_lstm":
        return PPO if algorithm == "ppo" else SAC
    try:
        from sb3_contrib import RecurrentPPO
    except ImportError as error:
        raise missing("ppo_lstm", "sb3-contrib", "agents") from error
    return RecurrentPPO


def hyperparameters(
    algorithm: str, env_id: str, changes: Mapping[str, Any] | None = None, file: Path | None = None
) -> dict[str, Any]:
    """The hyperparameters of an algorithm for an environment, with `changes` put in.

    `file` is read in place of the algorithm's own. Raises `ValueError` for an unknown algorithm,
    environment or hyperparameter, with the closest known name.
    """
    known = [name for name in inspect.signature(algorithm_class(algorithm)).parameters if name not in _FIXED]
    path = file or HYPERPARAMETER_FILES / f"{algorithm}.yml"
    tables = yaml.safe_load(path.read_text(encoding="utf-8"))
    if env_id not in tables:
        raise ValueError(f"{path.name} has no hyperparameters for {env_id!r}; {closest(env_id, tables)}")
    chosen = {**tables[env_id], **(changes or {})}
    for name in chosen:
        if name not in (*known, *_OURS):
            raise ValueError(f"{algorithm}: unknown hyperparameter {name!r}; {closest(name, [*_OURS, *known])}")
    for name in _COUNTS:
        if name in chosen:
            chosen[name] = _count(algorithm, name, chosen[name])
    algorithm_arguments(chosen)  # refuses what cannot be read
    return chosen


def algorithm_arguments(chosen: Mapping[str, Any]) -> dict[str, Any]:
    """What goes to the algorithm itself, with schedules such as `lin_8e-4` as functions."""
    arguments = {name: value for name, value in chosen.items() if name not in _OURS}
    for name in _SCHEDULES:
        if isinstance(arguments.get(name), str):
            arguments[name] = schedule(arguments[name])
    if "policy_kwargs" in arguments:
        arguments["policy_kwargs"] = policy_kwargs(arguments["policy_kwargs"])
    if isinstance(arguments.get("train_freq"), list):
        arguments["train_freq"] = tuple(arguments["train_freq"])
    return arguments


def _count(algorithm: str, name: str, value: Any) -> int:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = 0.0
    if number < 1 or number != int(number):
        raise ValueError(f"{algorithm}: {name} = {value} is not allowed; allowed: whole numbers >= 1")
    return int(number)
