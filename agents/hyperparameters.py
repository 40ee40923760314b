"""Hyperparameters: read from rl-zoo3's YAML format, changed from the command line, and checked."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import yaml
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm

from drillrig_env.parameters import closest

ALGORITHMS: dict[str, type[BaseAlgorithm]] = {"ppo": PPO, "sac": SAC}
"""The algorithms by the name that the command line takes."""

_FOLDER = Path(__file__).parent / "hyperparams"
_OURS = ("n_envs", "n_timesteps", "env_kwargs", "policy")  # used by training itself, not by the algorithm
_FIXED = ("self", "env", "seed", "tensorboard_log", "verbose", "_init_setup_model", "device")


def hyperparameters(algorithm: str, env_id: str, changes: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """The hyperparameters of an algorithm for an environment, with `changes` put in.

    Raises `ValueError` for an unknown algorithm, environment or hyperparameter, with the closest known name.
    """
    if algorithm not in ALGORITHMS:
        raise ValueError(f"algorithm {algorithm!r} is not known; {closest(algorithm, ALGORITHMS)}")
    path = _FOLDER / f"{algorithm}.yml"
    tables = yaml.safe_load(path.read_text(encoding="utf-8"))
    if env_id not in tables:
        raise ValueError(f"{path.name} has no hyperparameters for {env_id!r}; {closest(env_id, tables)}")
    known = [name for name in inspect.signature(ALGORITHMS[algorithm].__init__).parameters if name not in _FIXED]
    chosen = {**tables[env_id], **(changes or {})}
    for name in chosen:
        if name not in (*known, *_OURS):
            raise ValueError(f"{algorithm}: unknown hyperparameter {name!r}; {closest(name, [*_OURS, *known])}")
    chosen["n_envs"], chosen["n_timesteps"] = int(chosen["n_envs"]), int(float(chosen["n_timesteps"]))
    for name in ("n_envs", "n_timesteps"):
        if chosen[name] < 1:
            raise ValueError(f"{algorithm}: {name} = {chosen[name]} is not allowed; allowed: >= 1")
    return chosen


def algorithm_arguments(chosen: Mapping[str, Any]) -> dict[str, Any]:
    """What goes to the algorithm itself, with schedules such as `lin_8e-4` as functions."""
    arguments = {name: value for name, value in chosen.items() if name not in ("n_envs", "n_timesteps", "env_kwargs")}
    for name in ("learning_rate", "clip_range"):
        if isinstance(arguments.get(name), str):
            arguments[name] = schedule(arguments[name])
    return arguments


def schedule(text: str) -> float | Callable[[float], float]:
    """`lin_8e-4`: falling linearly from 8e-4 to zero over the training; a plain number: constant."""
    falling = text.startswith("lin_")
    try:
        start = float(text.removeprefix("lin_"))
    except ValueError as error:
        raise ValueError(f"schedule {text!r} is not allowed; allowed: a number, or lin_<number>") from error
    return (lambda remaining: remaining * start) if falling else start
