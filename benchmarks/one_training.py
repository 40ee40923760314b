"""One training that is timed, in a fresh process with a number of cores.

On `DrillRig-v0` it is `agents.training.train.train` itself, with TensorBoard log and checkpoints, so that what is timed
is what users get; any other environment is Gymnasium's, as SB3's `make_vec_env` gives it.
"""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.env_util import make_vec_env

from agents.policy.agent import Agent
from agents.policy.environment import environment_arguments, make_environment
from agents.training.hyperparameters import HYPERPARAMETER_FILES, algorithm_arguments, algorithm_class
from agents.training.settings import Training, checked_config
from agents.training.train import train
from agents.training.validation_rigs import validate
from benchmarks.measure import in_new_process
from benchmarks.shares import Watch, seconds_of_a_reading, watched
from drillrig_env.jit.threads import available_threads
from drillrig_env.parameters import refuse

RIG = "DrillRig-v0"
GOAL, RIGS = 0.9, 200  # mitigated share to reach, and the rigs that it is a share of, as many as train.py takes
LIBRARIES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True)
class Run:
    """One training. It ends after `chunks` chunks of `chunk_steps` steps; validated, not before `GOAL` is reached."""

    algorithm: str
    environment: str = RIG
    cores: int = 1
    torch_threads: int = 1
    seed: int = 0
    chunk_steps: int = 1
    chunks: int = 5
    validate_every: int | None = None  # steps; on RIG only
    hyperparams: Mapping[str, Any] = field(default_factory=dict)  # changes to the shipped ones


def in_fresh_process(run: Run) -> dict[str, Any]:
    """`timed_training` in a spawned process that may use `run.cores` cores.

    Raises `ValueError` for more cores than there are, and `RuntimeError` with the reason where the training fails.
    """
    check_cores(run.cores)
    with _limits(run.cores, run.torch_threads), tempfile.TemporaryDirectory() as folder:
        found: dict[str, Any] = in_new_process(timed_training, run, Path(folder))
    return found


def check_cores(cores: int) -> None:
    """`ValueError` for a number of cores that this process cannot have."""
    if not 1 <= cores <= available_threads():
        raise refuse("training", "cores", cores, "", f"1 to {available_threads()}")


@contextlib.contextmanager
def _limits(cores: int, threads: int) -> Iterator[None]:
    """Within the block, new processes run on the first `cores` cores, and libraries start `threads` threads in them.

    Where the system has no affinity (macOS, Windows), only the numbers of threads are limited.
    """
    before = {name: os.environ.get(name) for name in LIBRARIES}
    allowed = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
    os.environ.update(dict.fromkeys(LIBRARIES, str(threads)))
    try:
        if allowed:
            os.sched_setaffinity(0, sorted(allowed)[:cores])
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        if allowed:
            os.sched_setaffinity(0, allowed)


def timed_training(run: Run, folder: Path) -> dict[str, Any]:
    """Train in this process, with the run folder in `folder`, and return what the watch saw; times in s.

    `reached` holds steps and seconds at which `GOAL` was first seen, None where it was not. `chunks` and
    `validations` hold lists with an entry each. `compile_seconds`, of the rig alone, went before the training.
    """
    training = Training(
        run.algorithm,
        seed=run.seed,
        hyperparams=run.hyperparams,
        conf_file=HYPERPARAMETER_FILES / "soft_drive" / f"{run.algorithm}.yml",
        eval_freq=-1,
        log_folder=folder,
        threads=run.cores,
        progress=False,
    )
    config = checked_config(training)
    kind, chosen = algorithm_class(run.algorithm), config["hyperparameters"]
    arguments = environment_arguments(RIG, {**config["env_kwargs"], "threads": run.cores})

    def mitigated_share(model: BaseAlgorithm) -> float:
        return float(validate(Agent(model, config), arguments, RIGS).mitigated.mean())

    watch = Watch(
        run.chunk_steps,
        run.chunks,
        mitigated_share if run.validate_every else None,
        run.validate_every or 1,
        GOAL,
        run.torch_threads,
    )
    compile_seconds = None
    with watched(kind, watch), contextlib.redirect_stdout(io.StringIO()):
        if run.environment == RIG:
            compile_seconds = _load_kernels(arguments)
            train(training)
        else:
            env = make_vec_env(run.environment, chosen["n_envs"], seed=run.seed)
            model = kind(env=env, seed=run.seed, device="cpu", **algorithm_arguments(chosen))
            model.learn(chosen["n_timesteps"])
    return {
        **asdict(run),
        "n_envs": chosen["n_envs"],
        "cores_allowed": available_threads(),
        "torch_threads_set": torch.get_num_threads(),
        "steps": watch.num_timesteps,
        "training_seconds": watch.seconds,
        "validation_seconds": watch.stopwatch.seconds["validation"],
        "compile_seconds": compile_seconds,
        "timers_percent": 100.0 * watch.stopwatch.readings * seconds_of_a_reading() / watch.seconds,
        "reached": watch.reached,
        "validations": watch.validations,
        "chunks": watch.chunks,
    }


def _load_kernels(arguments: Mapping[str, Any]) -> float:
    """Seconds to load the environment's machine code, or to compile it where there is none yet."""
    begin = time.perf_counter()
    env = make_environment(RIG, 1, 0, arguments)
    env.reset()
    env.step(np.zeros((1, 1), dtype=np.float32))
    return time.perf_counter() - begin
