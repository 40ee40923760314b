"""The folder of a training run: its models, and what made them.

| file | holds |
|---|---|
| `config.json` | command, algorithm, hyperparameters, environment, seed, versions: enough to train it again |
| `model.zip` | the agent at the end of training: the one that is evaluated and shipped |
| `best_model.zip` | the agent that did best in the evaluations during training |
| `first_model.zip` | the agent before its first step by trial, where one is held near it (`anchor`) |
| `evaluations.npz` | these evaluations: `timesteps` (k,); `results`, `mitigated`, `ep_lengths`, each (k, rigs) |
| `checkpoint.npz` | where an unfinished training goes on; gone when it is finished |
| `progress.json` | how far the training is, and how long it took |
| `tensorboard_1/` | curves |

Every file is whole or not there, and one process at a time trains in a folder (`drillrig_env.files`). Only what reads a
model needs PyTorch: agents are found, and named in a command's help, without it.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drillrig_env.extras import missing
from drillrig_env.files import read_json, write_text
from drillrig_env.parameters import closest

if TYPE_CHECKING:
    from agents.policy.agent import Agent

MODEL, BEST_MODEL, FIRST_MODEL, CONFIG = "model.zip", "best_model.zip", "first_model.zip", "config.json"
EVALUATIONS, CHECKPOINT, PROGRESS = "evaluations.npz", "checkpoint.npz", "progress.json"
IMITATED = "imitated.pt"
SEEDS = "seeds.json"
TRAINED = Path(__file__).parents[1] / "trained"
"""The agents that come with the package: of each the median seed's run folder, with `seeds.json` about all seeds."""

_MADE_BY = {"algorithm": str, "env_id": str, "env_kwargs": dict, "seed": int, "hyperparameters": dict}
"""What a config must tell, and as what."""

_KINDS = {str: "text", int: "a whole number", dict: "values by name"}


def new_run(parent: Path, algorithm: str, folder: Path | None = None) -> Path:
    """Make `folder`, or the next free `<parent>/<algorithm>_<number>`, which no other process then gets.

    `ValueError` where `folder` is there already.
    """
    if folder is not None:
        try:
            folder.mkdir(parents=True)
        except FileExistsError as error:
            raise ValueError(f"run folder {folder} is there already; choose another, or remove it") from error
        return folder
    parent.mkdir(parents=True, exist_ok=True)
    number = 1
    while True:
        folder = parent / f"{algorithm}_{number}"
        try:
            folder.mkdir()
        except FileExistsError:
            number += 1
        else:
            return folder


def is_run(path: str | Path) -> bool:
    """Whether a path is the folder of a run."""
    return (Path(path) / CONFIG).is_file()


def is_finished(path: str | Path) -> bool:
    """Whether a run has learnt from all the steps that it was to have, and its model is there to be read."""
    from agents.policy.weights import saved_steps

    folder = Path(path)
    total = read_config(folder)["hyperparameters"]["n_timesteps"]
    return not (folder / CHECKPOINT).exists() and saved_steps(folder / MODEL) >= total


def shipped(trained: Path | None = None) -> list[str]:
    """The names of the agents that come with the package, or of those in another folder of shipped ones."""
    folders = (trained or TRAINED).glob("*")
    return sorted(path.name for path in folders if is_run(path) and not path.name.startswith("."))


def find_run(name: str | Path) -> Path:
    """The run folder at a path, or of a shipped agent by name. `ValueError` where there is neither."""
    for path in (Path(name), TRAINED / name):
        if is_run(path):
            return path
    hint = closest(str(name), [*shipped(), "the folder of a run"])
    raise ValueError(f"{name}: neither a shipped agent nor the folder of a run (it has no {CONFIG}); {hint}")


def read_seeds(path: str | Path) -> dict[str, Any] | None:
    """What `agents.shipping.ship` wrote about all training seeds of a shipped agent; None where there is nothing."""
    file = Path(path) / SEEDS
    return read_json(file, "ship the agent again") if file.is_file() else None


def seeds_of(path: str | Path) -> dict[str, Any]:
    """The same of an agent that must be shipped. `ValueError` where none is at that path."""
    seeds = read_seeds(path) if is_run(path) else None
    if seeds is None:
        raise ValueError(f"{path} is not a shipped agent with a {SEEDS}; make it with: python -m agents.shipping.ship")
    return seeds


def write_config(folder: Path, config: dict[str, Any]) -> None:
    """Write what made a run."""
    write_text(folder / CONFIG, json.dumps(config, indent=2) + "\n")


def read_config(path: str | Path) -> dict[str, Any]:
    """The config of a run: algorithm, hyperparameters, environment, seed and versions.

    `ValueError` naming the file where it is damaged.
    """
    file = Path(path) / CONFIG
    remedy = "write it again after another run's with the same settings, or train again"
    config = read_json(file, remedy)
    missing = [name for name in _MADE_BY if name not in config]
    if missing:
        raise ValueError(f"{file} is damaged: it does not tell {', '.join(missing)}; {remedy}")
    for name, kind in _MADE_BY.items():
        if not isinstance(config[name], kind):
            raise ValueError(f"{file} is damaged: {name} = {config[name]!r}; allowed: {_KINDS[kind]}; {remedy}")
    return config


def load_policy(path: str | Path, best: bool = False) -> Agent:
    """The trained agent of a run: its last model, or with `best` the best during training.

    The last is the default because the best was chosen by its score, which flatters it. Only weights are read from
    the model, so that somebody else's run executes nothing (`agents.policy.weights`). Raises `ValueError` where the
    run has left no such model, or a damaged one, and `ImportError` where PyTorch is missing.
    """
    try:
        from agents.policy.agent import Agent
        from agents.policy.weights import load_weights
    except ModuleNotFoundError as error:
        raise missing("a trained agent", "PyTorch and Stable-Baselines3", "agents") from error
    name = BEST_MODEL if best else MODEL
    model = Path(path) / name
    if not model.is_file():
        raise ValueError(f"{path}: the run has no {name}; it may have been stopped before the first save")
    config = read_config(path)
    agent = Agent(load_weights(model, config), config)
    agent.known_as = str(path)
    return agent
