"""Train an agent: Stable-Baselines3 on the project's `VecEnv`, with a run folder that can be made again."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch

import drillrig_env
from agents.hyperparameters import ALGORITHMS, algorithm_arguments, hyperparameters
from agents.run_folder import CONFIG, MODEL, new_run
from drillrig_env.evaluation.report import provenance
from drillrig_env.evaluation.suites import EVALUATION_SEEDS
from drillrig_env.parameters import refuse


@dataclass(frozen=True)
class Training:
    """One training run, every knob of it."""

    algorithm: str = "ppo"
    env_id: str = "DrillRig-v0"
    seed: int = 0
    n_timesteps: int | None = None  # default: the hyperparameter file's
    hyperparams: Mapping[str, Any] = field(default_factory=dict)  # changes to the file's
    env_kwargs: Mapping[str, Any] = field(default_factory=dict)  # beside the file's
    log_folder: Path = Path("runs")
    run_folder: Path | None = None  # default: the next free one in log_folder
    tensorboard: bool = True
    progress: bool = True


def train(training: Training) -> Path:
    """Train, save the model and its config, and return the run's folder.

    Ctrl-C ends the training early and keeps what was learnt. Raises `ValueError` for an unknown or
    impossible setting before anything is written.
    """
    changes = dict(training.hyperparams)
    if training.n_timesteps is not None:
        changes["n_timesteps"] = training.n_timesteps
    chosen = hyperparameters(training.algorithm, training.env_id, changes)
    if not 0 <= training.seed < EVALUATION_SEEDS - chosen["n_envs"]:
        raise refuse("train", "seed", training.seed, "", f"0 to {EVALUATION_SEEDS - chosen['n_envs'] - 1}")
    torch.set_num_threads(1)  # faster than two for networks of this size
    env_kwargs = {**chosen.get("env_kwargs", {}), **training.env_kwargs}
    env = drillrig_env.make_sb3(chosen["n_envs"], seed=training.seed, **env_kwargs)
    model = ALGORITHMS[training.algorithm](env=env, seed=training.seed, device="cpu", **algorithm_arguments(chosen))
    folder = new_run(training.log_folder, training.algorithm, training.run_folder)
    config = {
        "algorithm": training.algorithm,
        "env_id": training.env_id,
        "env_kwargs": env_kwargs,
        "seed": training.seed,
        "hyperparameters": chosen,
        "command": sys.argv,
        "provenance": provenance(),
    }
    (folder / CONFIG).write_text(json.dumps(config, indent=2) + "\n", encoding="utf-8")
    if training.tensorboard:
        model.tensorboard_log = str(folder)
    try:
        model.learn(chosen["n_timesteps"], progress_bar=training.progress, tb_log_name="tensorboard")
    except KeyboardInterrupt:
        print(f"stopped after {model.num_timesteps:,} of {chosen['n_timesteps']:,} steps; keeping the model")
    finally:
        model.save(folder / MODEL)
    return folder
