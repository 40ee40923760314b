"""Train an agent: Stable-Baselines3 on the project's `VecEnv`, with a run folder that can be made again."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from agents.policy.environment import environment_arguments, make_environment
from agents.policy.run_folder import CHECKPOINT, MODEL, is_run, new_run, read_config, write_config
from agents.training.callbacks import Checkpoint, Evaluate, Stopped
from agents.training.checkpoint import load_checkpoint
from agents.training.hyperparameters import algorithm_arguments, algorithm_class, hyperparameters
from agents.training.progress import ShowProgress
from drillrig_env.evaluation.provenance import provenance
from drillrig_env.parameters import refuse
from drillrig_env.seeds import TRAINING_SEEDS

_PARTS = 10
"""A training is evaluated, and its checkpoint written, this many times unless it is told otherwise."""


@dataclass(frozen=True)
class Training:
    """One training run, every knob of it."""

    algorithm: str = "ppo"
    env_id: str = "DrillRig-v0"
    seed: int = 0
    n_timesteps: int | None = None  # default: the hyperparameter file's
    hyperparams: Mapping[str, Any] = field(default_factory=dict)  # changes to the file's
    env_kwargs: Mapping[str, Any] = field(default_factory=dict)  # beside the file's
    conf_file: Path | None = None  # default: the algorithm's own in agents/hyperparams
    eval_freq: int | None = None  # steps between evaluations; default: a tenth of the training; negative: none
    eval_episodes: int = 200  # rigs that an evaluation takes
    save_freq: int | None = None  # steps between checkpoints; default: a tenth of the training
    log_folder: Path = Path("runs")
    run_folder: Path | None = None  # default: the next free one in log_folder
    threads: int | None = None  # that step the rigs; the result is the same; default: all cores
    tensorboard: bool = True
    progress: bool = True


def train(training: Training) -> Path:
    """Train, save the model and its config, and return the run's folder.

    Ctrl-C ends the training after the current rollout and keeps what was learnt; `resume` goes on from
    there. Raises `ValueError` for an unknown or impossible setting before anything is written.
    """
    config = checked_config(training)
    _use_one_thread()
    env = _environment(config, training.threads)
    chosen = config["hyperparameters"]
    model = algorithm_class(training.algorithm)(
        env=env, seed=training.seed, device="cpu", **algorithm_arguments(chosen)
    )
    folder = new_run(training.log_folder, training.algorithm, training.run_folder)
    write_config(folder, {**config, "provenance": provenance()})
    if training.tensorboard:
        model.tensorboard_log = str(folder)
    _learn(model, folder, config, training.threads, training.progress)
    return folder


def resume(folder: Path, threads: int | None = None, progress: bool = True) -> Path:
    """Go on with a training that was stopped, from its checkpoint to the total that it was to have.

    It ends as it would have without the stop (see `agents.training.checkpoint`). Raises `ValueError` where there
    is no run, or no checkpoint in it.
    """
    if not is_run(folder):
        raise ValueError(f"{folder} is not the folder of a run; allowed: one that `train.py` has made")
    path = folder / CHECKPOINT
    if not path.is_file():
        raise ValueError(f"{folder}: the run has no {CHECKPOINT}: it is finished, or was stopped before the first one")
    config = read_config(folder)
    _use_one_thread()
    model = load_checkpoint(path, config["algorithm"], _environment(config, threads))
    if model.tensorboard_log:
        model.tensorboard_log = str(folder)
    _learn(model, folder, config, threads, progress, resumed=True)
    return folder


def checked_config(training: Training) -> dict[str, Any]:
    """Everything that fixes a run, as plain values. `ValueError` for an unknown or impossible setting."""
    changes = dict(training.hyperparams)
    if training.n_timesteps is not None:
        changes["n_timesteps"] = training.n_timesteps
    chosen = hyperparameters(training.algorithm, training.env_id, changes, training.conf_file)
    env_kwargs = {**chosen.get("env_kwargs", {}), **training.env_kwargs}
    environment_arguments(training.env_id, env_kwargs)
    last = TRAINING_SEEDS.stop - chosen["n_envs"] - 1
    if not 0 <= training.seed <= last:
        raise refuse("train", "seed", training.seed, "", f"0 to {last}")
    part = max(1, chosen["n_timesteps"] // _PARTS)
    for name in ("eval_episodes", "save_freq"):
        value = getattr(training, name)
        if value is not None and value < 1:
            raise refuse("train", name, value, "", ">= 1")
    if training.eval_freq == 0:
        raise refuse("train", "eval_freq", 0, "steps", ">= 1, or negative for no evaluation")
    return {
        "algorithm": training.algorithm,
        "env_id": training.env_id,
        "env_kwargs": env_kwargs,
        "seed": training.seed,
        "hyperparameters": chosen,
        "eval_freq": training.eval_freq or part,
        "eval_episodes": training.eval_episodes,
        "save_freq": training.save_freq or part,
        "command": sys.argv,
    }


def _use_one_thread() -> None:
    """PyTorch on one thread: faster than two for networks of this size, and the first weights depend on it."""
    torch.set_num_threads(1)


def _environment(config: Mapping[str, Any], threads: int | None) -> VecEnv:
    chosen = config["hyperparameters"]
    env_kwargs = {**config["env_kwargs"], "threads": threads}
    frames = chosen.get("frame_stack", 1)
    return make_environment(config["env_id"], chosen["n_envs"], config["seed"], env_kwargs, frames)


def _learn(
    model: BaseAlgorithm,
    folder: Path,
    config: Mapping[str, Any],
    threads: int | None,
    progress: bool,
    resumed: bool = False,
) -> None:
    """Learn until the total is reached or a stop is asked for, and save the model."""
    total = config["hyperparameters"]["n_timesteps"]
    evaluate = None
    if config["eval_freq"] > 0:
        arguments = environment_arguments(config["env_id"], {**config["env_kwargs"], "threads": threads})
        evaluate = Evaluate(folder, config, arguments, config["eval_episodes"], config["eval_freq"])
    checkpoint = Checkpoint(folder, config["save_freq"])
    shown = ShowProgress(folder, total, evaluate, progress)
    callbacks: list[BaseCallback] = [shown, *([evaluate] if evaluate else []), checkpoint]
    left = total - model.num_timesteps
    try:
        with checkpoint:
            model.learn(left, callback=callbacks, tb_log_name="tensorboard", reset_num_timesteps=not resumed)
        (folder / CHECKPOINT).unlink(missing_ok=True)
    except (KeyboardInterrupt, Stopped):
        print(f"{folder}: stopped after {model.num_timesteps:,} of {total:,} steps; keeping the model")
        if (folder / CHECKPOINT).is_file():
            print(f"to go on: python train.py --resume {folder}")
    finally:
        shown.close()
        model.save(folder / MODEL)
