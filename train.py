"""Train an agent on random rigs.

    python train.py ppo                                    # a minute or two on one core
    python train.py ppo --n-timesteps 10000000 --seed 3
    python train.py sac --hyperparams batch_size:256 gamma:0.98
    python eval.py constant jump_ease runs/ppo_1           # then compare it

Flags are named as in rl-zoo3 where there is one. Ctrl-C stops early and keeps what was learnt.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import yaml

from agents.hyperparameters import ALGORITHMS
from agents.training import Training, train


def main() -> None:
    """Parse the command line and train."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("algorithm", choices=list(ALGORITHMS), help="the algorithm")
    parser.add_argument("--env", default="DrillRig-v0", help="environment id (default: DrillRig-v0)")
    parser.add_argument(
        "-n", "--n-timesteps", type=lambda text: int(float(text)), help="steps; default: agents/hyperparams"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of draws and networks (default: 0)")
    parser.add_argument(
        "-f", "--log-folder", type=Path, default=Path("runs"), help="parent of run folders (default: runs)"
    )
    parser.add_argument("--run-folder", type=Path, help="the run's own folder instead; it must not exist yet")
    parser.add_argument(
        "-params", "--hyperparams", nargs="+", default=[], metavar="NAME:VALUE", help="change hyperparameters"
    )
    parser.add_argument(
        "--env-kwargs", nargs="+", default=[], metavar="NAME:VALUE", help="arguments of the environment"
    )
    parser.add_argument("--no-tensorboard", action="store_true", help="write no TensorBoard log")
    parser.add_argument("--no-progress", action="store_true", help="show no progress bar")
    arguments = parser.parse_args()
    try:
        folder = train(
            Training(
                algorithm=arguments.algorithm,
                env_id=arguments.env,
                seed=arguments.seed,
                n_timesteps=arguments.n_timesteps,
                hyperparams=pairs(arguments.hyperparams),
                env_kwargs=pairs(arguments.env_kwargs),
                log_folder=arguments.log_folder,
                run_folder=arguments.run_folder,
                tensorboard=not arguments.no_tensorboard,
                progress=not arguments.no_progress,
            )
        )
    except ValueError as error:
        parser.error(str(error))
    print(f"run folder: {folder}")


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
    main()
