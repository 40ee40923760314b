"""Train an agent on random rigs.

    python train.py                                        # PPO on DrillRig-v0
    python train.py ppo --n-timesteps 10000000 --seed 3
    python train.py ppo --env DrillRigSurface-v0 --seeds 5 --jobs 2
    python train.py sac --hyperparams batch_size:256 gamma:0.98
    python train.py --resume runs/ppo_1                    # go on after Ctrl-C
    python eval.py constant jump_ease runs/ppo_1           # then compare it

Flags are named as in rl-zoo3 where there is one. Ctrl-C finishes the rollout, saves and stops; a second
one stops at once, and training can go on from the last checkpoint.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from agents.policy.run_folder import is_run
from agents.training.hyperparameters import ALGORITHMS
from agents.training.seeds import resume_seeds, train_seeds
from agents.training.train import Training, resume, train


def main(given: Sequence[str] | None = None) -> int:
    """Parse the command line and train."""
    parser = argument_parser()
    arguments = parser.parse_args(given)
    try:
        folder = run(arguments)
    except (ValueError, OSError, ImportError) as error:
        parser.error(str(error))
    except RuntimeError as error:
        raise SystemExit(f"{parser.prog}: {error}") from None
    print(f"run folder: {folder}")
    return 0


def run(arguments: argparse.Namespace) -> Path:
    """Do what the command line asks for, and return the folder of it."""
    progress = not arguments.no_progress
    if arguments.resume:
        if is_run(arguments.resume):
            return resume(arguments.resume, arguments.threads, progress)
        return resume_seeds(arguments.resume, arguments.jobs, arguments.threads, progress)
    training = Training(
        algorithm=arguments.algo or arguments.algorithm,
        env_id=arguments.env,
        seed=arguments.seed,
        n_timesteps=arguments.n_timesteps,
        hyperparams=pairs(arguments.hyperparams),
        env_kwargs=pairs(arguments.env_kwargs),
        conf_file=arguments.conf_file,
        eval_freq=arguments.eval_freq,
        eval_episodes=arguments.eval_episodes,
        save_freq=arguments.save_freq,
        log_folder=arguments.log_folder,
        run_folder=arguments.run_folder,
        threads=arguments.threads,
        tensorboard=not arguments.no_tensorboard,
        progress=progress,
    )
    return train(training) if arguments.seeds == 1 else train_seeds(training, arguments.seeds, arguments.jobs)


def argument_parser() -> argparse.ArgumentParser:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("algorithm", nargs="?", default="ppo", choices=list(ALGORITHMS), help="the algorithm (default: ppo)")
    add("--algo", choices=list(ALGORITHMS), help="the same, as rl-zoo3 has it")
    add("--env", default="DrillRig-v0", help="environment id (default: DrillRig-v0)")
    add("-n", "--n-timesteps", type=count, help="steps; default: agents/hyperparams")
    add("--seed", type=int, default=0, help="seed of draws and networks (default: 0)")
    add("--seeds", type=int, default=1, help="train this many seeds, from --seed on, into <run folder>/seed_<s>")
    add("--jobs", type=int, default=1, help="of these seeds, train so many at a time (default: 1)")
    add("--threads", type=int, help="threads that step the rigs (default: all cores; 1 with --jobs above 1)")
    add("--resume", type=Path, metavar="RUN", help="go on with a stopped run, or with the seeds in a folder")
    add("-f", "--log-folder", type=Path, default=Path("runs"), help="parent of run folders (default: runs)")
    add("--run-folder", type=Path, help="the run's own folder instead; it must not exist yet")
    add("-conf", "--conf-file", type=Path, help="hyperparameter file in place of agents/hyperparams/<algorithm>.yml")
    add("-params", "--hyperparams", nargs="+", default=[], metavar="NAME:VALUE", help="change hyperparameters")
    add("--env-kwargs", nargs="+", default=[], metavar="NAME:VALUE", help="arguments of the environment")
    add("--eval-freq", type=count, help="steps between evaluations (default: a tenth of all; negative: none)")
    add("--eval-episodes", type=int, default=200, help="rigs that an evaluation takes (default: 200)")
    add("--save-freq", type=count, help="steps between checkpoints (default: a tenth of all)")
    add("--no-tensorboard", action="store_true", help="write no TensorBoard log")
    add("--no-progress", action="store_true", help="show no progress")
    return parser


def count(text: str) -> int:
    """A number of steps, such as 2000000 or 2e6."""
    return int(float(text))


def pairs(texts: list[str]) -> dict[str, Any]:
    """`["gamma:0.98"]` as `{"gamma": 0.98}`; values are read as YAML."""
    found = {}
    for text in texts:
        name, colon, value = text.partition(":")
        if not colon or not value:
            raise ValueError(f"{text!r} is not allowed; allowed: NAME:VALUE, such as gamma:0.98")
        found[name] = yaml.safe_load(value)
    return found


if __name__ == "__main__":
    sys.exit(main())
