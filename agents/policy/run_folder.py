"""The folder of a training run: its models, and what made them.

| file | holds |
|---|---|
| `config.json` | command, algorithm, hyperparameters, environment, seed, versions: enough to train it again |
| `model.zip` | the agent at the end of training: the one that is evaluated and shipped |
| `best_model.zip` | the agent that did best in the evaluations during training |
| `evaluations.npz` | these evaluations: `timesteps` (k,); `results`, `mitigated`, `ep_lengths`, each (k, rigs) |
| `checkpoint.npz` | where an unfinished training goes on; gone when it is finished |
| `progress.json` | how far the training is, and how long it took |
| `tensorboard_1/` | curves |
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from agents.policy.agent import Agent
from agents.training.hyperparameters import algorithm_class
from drillrig_env.parameters import closest

MODEL, BEST_MODEL, CONFIG = "model.zip", "best_model.zip", "config.json"
EVALUATIONS, CHECKPOINT, PROGRESS = "evaluations.npz", "checkpoint.npz", "progress.json"
SEEDS = "seeds.json"
TRAINED = Path(__file__).parents[1] / "trained"
"""The agents that come with the package: of each the median seed's run folder, with `seeds.json` about all seeds."""

_ONLY_FOR_TRAINING: dict[str, Any] = {  # put in place of what is saved, so that no other version must read it
    "learning_rate": 0.0,
    "clip_range": 0.0,
    "clip_range_vf": None,
    "_last_obs": None,
    "_last_episode_starts": None,
    "ep_info_buffer": None,
    "ep_success_buffer": None,
    "buffer_size": 1,
}


def new_run(parent: Path, algorithm: str, folder: Path | None = None) -> Path:
    """Make `folder`, or the next free `<parent>/<algorithm>_<number>`. `ValueError` where `folder` is there already."""
    number = 1
    while folder is None:
        candidate = parent / f"{algorithm}_{number}"
        folder = None if candidate.exists() else candidate
        number += 1
    if folder.exists():
        raise ValueError(f"run folder {folder} is there already; choose another, or remove it")
    folder.mkdir(parents=True)
    return folder


def is_run(path: str | Path) -> bool:
    """Whether a path is the folder of a run."""
    return (Path(path) / CONFIG).is_file()


def shipped() -> list[str]:
    """The names of the agents that come with the package."""
    return sorted(path.name for path in TRAINED.glob("*") if is_run(path))


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
    if not file.is_file():
        return None
    content: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return content


def write_config(folder: Path, config: dict[str, Any]) -> None:
    """Write what made a run."""
    (folder / CONFIG).write_text(json.dumps(config, indent=2) + "\n", encoding="utf-8")


def read_config(path: str | Path) -> dict[str, Any]:
    """The config of a run: algorithm, hyperparameters, environment, seed and versions."""
    content: dict[str, Any] = json.loads((Path(path) / CONFIG).read_text(encoding="utf-8"))
    return content


def load_policy(path: str | Path, best: bool = False) -> Agent:
    """The trained agent of a run: its last model, or with `best` the best during training.

    The last is the default because the best was chosen by its score, which flatters it.
    Raises `ValueError` where the run has left no such model.
    """
    name = BEST_MODEL if best else MODEL
    model = Path(path) / name
    if not model.is_file():
        raise ValueError(f"{path}: the run has no {name}; it may have been stopped before the first save")
    config = read_config(path)
    loaded = algorithm_class(config["algorithm"]).load(model, device="cpu", custom_objects=_ONLY_FOR_TRAINING)
    return Agent(loaded, config)
