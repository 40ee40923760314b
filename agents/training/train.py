"""Train an agent: Stable-Baselines3 on the project's `VecEnv`, with a run folder that can be made again."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from agents.policy.environment import batch_of, environment_arguments, make_environment, task_of
from agents.policy.run_folder import (
    CHECKPOINT,
    IMITATED,
    MODEL,
    is_finished,
    is_run,
    new_run,
    read_config,
    write_config,
)
from agents.training.actor import is_finite
from agents.training.anchor import Anchor
from agents.training.callbacks import Checkpoint, Evaluate
from agents.training.checkpoint import load_checkpoint, save_model
from agents.training.curriculum import Curriculum, Stages
from agents.training.device import device_of, provenance_on
from agents.training.fine_tuning import take_weights
from agents.training.hyperparameters import TOLD, algorithm_arguments, algorithm_class
from agents.training.imitation import Imitation, imitate
from agents.training.progress import ShowProgress
from agents.training.settings import Training, checked_config
from agents.training.warm_up import WarmUp
from drillrig_env.command_line import Failed
from drillrig_env.files import check_writable, owned


def train(training: Training) -> Path:
    """Train, save the model and its config, and return the run's folder.

    Ctrl-C and SIGTERM end the training after the current rollout, keep what was learnt and raise
    `KeyboardInterrupt`; `resume` goes on from there. Raises `ValueError` for an unknown or impossible setting, and
    `OSError` for a folder that cannot be written, before anything is written; `Failed` for an error while learning.
    """
    config = checked_config(training)
    model = new_model(config, training.threads)
    check_writable(training.log_folder if training.run_folder is None else training.run_folder.parent)
    folder = new_run(training.log_folder, training.algorithm, training.run_folder)
    with owned(folder):
        write_config(folder, {**config, "provenance": provenance_on(model.device)})
        _learn(model, folder, config, training.threads, training.progress)
    return folder


def try_out(config: Mapping[str, Any], folder: Path, watched_by: Sequence[BaseCallback], threads: int | None) -> None:
    """Train as a config says, in an empty folder that is thrown away afterwards, with callbacks that watch."""
    _learn(new_model(config, threads), folder, config, threads, progress=False, watched_by=watched_by, kept=False)


def resume(
    folder: Path, threads: int | None = None, progress: bool = True, asked: Callable[[], bool] | None = None
) -> Path:
    """Go on with a training that was stopped, from its checkpoint to the total that it was to have.

    It ends as it would have without the stop (see `agents.training.checkpoint`); where there is no checkpoint yet, it
    begins again. `asked` is asked between rollouts whether to stop, and then stands in for Ctrl-C. Raises
    `ValueError` where there is no run, where it is finished or where its checkpoint is damaged, and
    `BlockingIOError` where another process trains in the folder.
    """
    if not is_run(folder):
        raise ValueError(f"{folder} is not the folder of a run; allowed: one that `train.py` has made")
    _check_unfinished(folder)  # a run that is finished is left as it is, without a lock of this process
    with owned(folder):
        _check_unfinished(folder)  # another process may just have finished it
        config, path = read_config(folder), folder / CHECKPOINT
        begun = path.is_file()
        model_file = folder / MODEL
        if not begun and model_file.is_file() and not zipfile.is_zipfile(model_file):
            raise ValueError(f"{model_file} is damaged; remove it, and --resume begins the training again")
        if begun:
            _use_one_thread()
            model = load_checkpoint(path, config["algorithm"], _environment(config, threads), device_of(config))
        else:
            model = new_model(config, threads)
        _learn(model, folder, config, threads, progress, begun, asked)
    return folder


def _check_unfinished(folder: Path) -> None:
    if is_finished(folder):
        raise ValueError(f"{folder}: nothing to go on with: the run is finished")


def new_model(config: Mapping[str, Any], threads: int | None = None) -> BaseAlgorithm:
    """A model as the config has it, before its first step, in its environment. `ValueError` where there is none."""
    _use_one_thread()
    device = device_of(config)
    env = _environment(config, threads)
    arguments = algorithm_arguments(config["hyperparameters"])
    try:
        model = algorithm_class(config["algorithm"])(env=env, seed=config["seed"], device=device, **arguments)
    except (AssertionError, RuntimeError, TypeError, ValueError) as error:  # Stable-Baselines3 has the last word
        raise ValueError(f"{config['algorithm']}: these hyperparameters are not allowed: {error}") from error
    if "resume_from" in config:
        take_weights(model, config["resume_from"])
    return model


def _use_one_thread() -> None:
    """PyTorch on one thread: faster than two for networks of this size, and the first weights depend on it."""
    torch.set_num_threads(1)


def _environment(config: Mapping[str, Any], threads: int | None) -> VecEnv:
    chosen = config["hyperparameters"]
    env_kwargs = {**config["env_kwargs"], "threads": threads}
    frames = chosen.get("frame_stack", 1)
    told, observer = config["algorithm"] in TOLD, chosen.get("observer")
    env = make_environment(config["env_id"], chosen["n_envs"], config["seed"], env_kwargs, frames, told, observer)
    if chosen.get("curriculum"):
        batch_of(env).change(**Stages.of(chosen["curriculum"]).environments(_own(config))[0])
    return env


def _own(config: Mapping[str, Any]) -> dict[str, Any]:
    """Of the environment's own task what a curriculum gives anew."""
    task = task_of(environment_arguments(config["env_id"], config["env_kwargs"]))
    return {"scenario": task.scenario, "noise": task.noise, "delay": task.delay}


def _learn(
    model: BaseAlgorithm,
    folder: Path,
    config: Mapping[str, Any],
    threads: int | None,
    progress: bool,
    begun: bool = False,
    asked: Callable[[], bool] | None = None,
    watched_by: Sequence[BaseCallback] = (),
    kept: bool = True,
) -> None:
    """Learn until the total is reached or a stop is asked for. The checkpoint goes when the last model is whole.

    Where the folder is not `kept`, neither is what was learnt before a stop or an error.
    """
    chosen = config["hyperparameters"]
    total = chosen["n_timesteps"]
    left = total - model.num_timesteps
    model.tensorboard_log = str(folder) if config.get("tensorboard", True) else None
    evaluate = None
    if config["eval_freq"] > 0:
        arguments = environment_arguments(config["env_id"], {**config["env_kwargs"], "threads": threads})
        evaluate = Evaluate(folder, config, arguments, config["eval_episodes"], config["eval_freq"])
    checkpoint = Checkpoint(folder, config["save_freq"], asked)
    shown = ShowProgress(folder, total, evaluate, progress)
    warm_up = WarmUp(chosen.get("critic_iterations", 0), chosen.get("staggered", False))
    callbacks: list[BaseCallback] = [shown, *([evaluate] if evaluate else []), checkpoint, warm_up, *watched_by]
    if chosen.get("anchor"):
        callbacks.append(Anchor(folder, config, chosen["anchor"]))
    if chosen.get("curriculum"):
        callbacks.append(Curriculum(Stages.of(chosen["curriculum"]), _own(config)))
    imitates = bool(chosen.get("imitation")) and not begun
    try:
        with checkpoint:
            if imitates:
                _imitate(model, config, shown, checkpoint, folder / IMITATED if kept else None)
                imitates = False
            model.learn(left, callback=callbacks, tb_log_name="tensorboard", reset_num_timesteps=not begun)
            save_model(folder / MODEL, model)
            for file in (CHECKPOINT, IMITATED):
                (folder / file).unlink(missing_ok=True)
    except (ValueError, FloatingPointError) as error:
        failure = Failed(f"{folder}: the training failed: {error}" if kept else f"the training failed: {error}")
        if kept:
            _keep(model, folder, total, imitates, failure)
        raise failure from error
    except BaseException as end:
        if kept:
            _keep(model, folder, total, imitates, end)
        raise
    finally:
        shown.close()
        _remove_empty_log(model)


def _remove_empty_log(model: BaseAlgorithm) -> None:
    """Remove the folder that Stable-Baselines3 makes among the temporary files where nothing is logged."""
    folder = getattr(model, "_logger", None) and model.logger.dir
    if folder and model.tensorboard_log is None:
        with suppress(OSError):
            Path(folder).rmdir()


def _imitate(
    model: BaseAlgorithm, config: Mapping[str, Any], shown: ShowProgress, checkpoint: Checkpoint, file: Path | None
) -> None:
    """Let the model imitate before it learns, or go on with that after a stop, from what `file` keeps."""
    env = model.get_env()
    assert env is not None

    def told(steps: int) -> None:
        checkpoint.at_once = False
        checkpoint.stop_if_asked()
        shown.imitates(steps)

    how = Imitation.of(config["hyperparameters"]["imitation"])
    shown.imitates(0)
    checkpoint.at_once = True  # a teacher for hundreds of rigs is designed for half a minute, and nothing to be kept
    if config["algorithm"] in TOLD:
        from agents.recurrent.imitation import imitate_episodes

        assert isinstance(model, algorithm_class(config["algorithm"]))
        imitate_episodes(model, env, how, config["seed"], told, file)  # type: ignore[arg-type]
    else:
        imitate(model, env, how, config["seed"], told, file)


def _keep(model: BaseAlgorithm, folder: Path, total: int, imitates: bool, end: BaseException) -> None:
    """Save what was learnt before a stop or an error, and add to it what is kept and how to go on.

    What still `imitates` has kept that itself, and is no agent yet.
    """
    if not is_finite(model.policy):
        end.add_note("its weights are no numbers any more, and not kept; a lower learning_rate may help")
        return
    if imitates:
        kept = (folder / IMITATED).is_file()
        end.add_note(f"{folder} keeps {'what' if kept else 'nothing that'} was imitated")
        end.add_note(f"to go on: python train.py --resume {folder}")
        return
    try:
        save_model(folder / MODEL, model)
        end.add_note(f"{folder} keeps the model of {model.num_timesteps:,} of {total:,} steps")
    except OSError as error:
        end.add_note(f"the model of {model.num_timesteps:,} of {total:,} steps could not be written ({error})")
    if not is_finished(folder):
        end.add_note(f"to go on: python train.py --resume {folder}")
