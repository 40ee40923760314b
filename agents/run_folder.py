"""The folder of a training run: the model, and what made it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm

from agents.hyperparameters import ALGORITHMS

MODEL, CONFIG = "model.zip", "config.json"


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


def read_config(path: str | Path) -> dict[str, Any]:
    """The config of a run: algorithm, hyperparameters, environment, seed and versions."""
    content: dict[str, Any] = json.loads((Path(path) / CONFIG).read_text(encoding="utf-8"))
    return content


def load_policy(path: str | Path) -> BaseAlgorithm:
    """The trained model of a run. `ValueError` where the run has left no model."""
    model = Path(path) / MODEL
    if not model.is_file():
        raise ValueError(f"{path}: the run has no {MODEL}; it may have been stopped before the first save")
    return ALGORITHMS[read_config(path)["algorithm"]].load(model, device="cpu")
