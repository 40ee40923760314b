"""A model from its weights alone: nothing that a `model.zip` holds is executed.

Stable-Baselines3 keeps a model's settings as pickles, and whoever reads a pickle runs what its maker put into it.
Here the settings come from the run's `config.json`, which is plain text, and of `model.zip` only the weights are
read, as tensors and nothing else. So a run folder of somebody else's can be evaluated and exported like one's own.
"""

from __future__ import annotations

import errno
import io
import json
import pickle
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.base_class import BaseAlgorithm
from torch import nn

from agents.policy.environment import environment_arguments
from agents.policy.observer import ESTIMATED
from agents.training.hyperparameters import algorithm_arguments, algorithm_class, hyperparameters
from drillrig_env.env.sensors import LIMIT, Sensors

_WEIGHTS, _SETTINGS = "policy.pth", "data"  # within Stable-Baselines3's archive
_DAMAGED = (zipfile.BadZipFile, KeyError, EOFError, RuntimeError, ValueError)
_REMEDY = "take another model of the run, or train it again"


def load_weights(path: Path, config: Mapping[str, Any]) -> BaseAlgorithm:
    """The model of a `model.zip`, made as the run's `config` says, with the weights that the file holds.

    It acts as the saved one did. Optimisers and whatever else only training needs begin anew. Raises `ValueError`
    naming the file where it is damaged, holds more than tensors, or does not fit the config, and where the config
    describes no model.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            weights, steps = _tensors(archive, _WEIGHTS), _steps(archive)
    except pickle.UnpicklingError as error:
        raise ValueError(f"{path} holds more than weights and is not read, since that could run any code") from error
    except (OSError, *_DAMAGED) as error:
        if isinstance(error, OSError) and error.errno != errno.EINVAL:  # which is a place beside the file's end
            raise
        raise ValueError(f"{path} is damaged: {_first_line(error)}; {_REMEDY}") from error
    try:
        model = untrained_model(config)
    except (ValueError, TypeError, AssertionError) as error:  # a config that was edited, or is of another version
        raise ValueError(f"{path.parent / 'config.json'} describes no model: {_first_line(error)}") from error
    try:
        model.policy.load_state_dict(weights)
    except (RuntimeError, TypeError, AttributeError) as error:
        raise ValueError(f"{path} does not fit the network of its config.json; {_REMEDY}") from error
    model.num_timesteps = steps
    return model


def give_saved(module: nn.Module, path: Path, name: str) -> bool:
    """Give a network the weights that a `model.zip` holds by this name beside the policy's; whether it has such."""
    try:
        with zipfile.ZipFile(path) as archive:
            module.load_state_dict(_tensors(archive, f"{name}.pth"))
    except (pickle.UnpicklingError, *_DAMAGED):
        return False
    return True


def _tensors(archive: zipfile.ZipFile, name: str) -> dict[str, torch.Tensor]:
    found: dict[str, torch.Tensor] = torch.load(io.BytesIO(archive.read(name)), map_location="cpu", weights_only=True)
    return found


def saved_steps(path: Path) -> int:
    """How many steps the model in a `model.zip` has learnt from; 0 where there is none that can be read."""
    try:
        with zipfile.ZipFile(path) as archive:
            return _steps(archive)
    except (OSError, *_DAMAGED):
        return 0


def untrained_model(config: Mapping[str, Any]) -> BaseAlgorithm:
    """A model as the run's `config` says, without environment and before its first step."""
    chosen = hyperparameters(config["algorithm"], config["env_id"], table=config["hyperparameters"])
    made: Any = algorithm_class(config["algorithm"])
    model: BaseAlgorithm = made(env=None, device="cpu", _init_setup_model=False, **algorithm_arguments(chosen))
    sensors = Sensors.named(environment_arguments(config["env_id"], config["env_kwargs"])["sensors"])
    estimated = len(ESTIMATED) if chosen.get("observer") else 0
    width = (estimated + len(sensors.channels)) * int(chosen.get("frame_stack", 1))
    model.observation_space = spaces.Box(-LIMIT, LIMIT, (width,), np.float32)
    model.action_space = spaces.Box(-1.0, 1.0, (1,), np.float32)
    model.n_envs = chosen["n_envs"]
    if getattr(model, "target_entropy", None) == "auto":  # SAC would ask an environment for the number of actions
        model.target_entropy = -1.0  # type: ignore[attr-defined]
    model._setup_model()
    return model


def _steps(archive: zipfile.ZipFile) -> int:
    return int(json.loads(archive.read(_SETTINGS))["num_timesteps"])


def _first_line(error: BaseException) -> str:
    return next(iter(str(error).splitlines()), type(error).__name__)
