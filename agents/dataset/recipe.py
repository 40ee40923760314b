"""What a data set is made of: policies, an environment, and how many episodes from which seed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from agents.policy.environment import check_arguments, environment_arguments, plain_arguments
from drillrig_env.allowed import COUNT, Allowed, File, Made, Switch, Text
from drillrig_env.drive import Drive
from drillrig_env.env.task import Task
from drillrig_env.parameters import check_fields, parameter, refuse
from drillrig_env.policy import Policy, channels_of, context_of, drive_of, find_policy
from drillrig_env.seeds import DATASET_SEEDS

BLOCK = 1_000_000
"""Rigs that belong to each seed of a data set."""

MIXED = "mixed"
"""The name of a data set of several policies."""


def _read_names(given: Any) -> tuple[str, ...]:
    """Names of policies, each once, from a sequence or from a text with commas between them."""
    names = tuple(name.strip() for name in given.split(",")) if isinstance(given, str) else tuple(map(str, given))
    labels = [label_of(name) for name in names]
    if not names or not all(names) or len(set(labels)) < len(labels):
        raise ValueError(f"policies {given!r} are not allowed; allowed: names of policies, each once, such as lqg,ppo")
    return names


@dataclass(frozen=True)
class Recipe:
    """What is recorded, and where to. `ValueError` for a field that is not allowed."""

    policies: tuple[str, ...] = parameter(
        ("lqg", "ppo", "constant"),
        meaning="who plays, by name, FILE.py:CLASS or a run's folder, with commas between",
        allowed=Made(_read_names, "names of policies"),
    )
    episodes: int = parameter(1000, "episodes", "how many of each policy", allowed=Allowed(1, BLOCK, whole=True))
    env_id: str = parameter("DrillRig-v0", meaning="environment id", allowed=Text("the id of an environment"))
    env_kwargs: Mapping[str, Any] = parameter(
        factory=dict, meaning="arguments of the environment", allowed=Made(dict, "values by name")
    )
    seed: int = parameter(
        0,
        meaning="which rigs: each number has a million of its own, which no suite and no training has",
        allowed=Allowed(0, len(DATASET_SEEDS) // BLOCK - 1, whole=True),
    )
    mixed: bool = parameter(False, meaning="one data set of all policies in place of one a policy", allowed=Switch())
    output: Path | None = parameter(
        None,
        meaning="folder of data sets",
        allowed=File(),
        none="Minari's: MINARI_DATASETS_PATH, or ~/.minari/datasets",
    )
    overwrite: bool = parameter(False, meaning="replace data sets of the same names", allowed=Switch())
    threads: int | None = parameter(
        None, meaning="threads that step the rigs; the result is the same", allowed=COUNT, none="all cores"
    )

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def first_seed(self) -> int:
        """The seed of the first rig; that of rig i is i more."""
        return DATASET_SEEDS.start + self.seed * BLOCK


@dataclass(frozen=True)
class Player:
    """A policy that was made for an environment: `env_kwargs` are plain values, its drive among them."""

    name: str
    policy: Policy
    env_id: str
    env_kwargs: Mapping[str, Any]

    @property
    def arguments(self) -> dict[str, Any]:
        """All arguments that `EpisodeBatch` needs."""
        return environment_arguments(self.env_id, self.env_kwargs)

    @property
    def task(self) -> Task:
        """What is played."""
        return Task.of(**self.arguments)


def find_players(recipe: Recipe) -> list[Player]:
    """The policies of a recipe, each made for its environment.

    `ValueError` where an argument of the environment is not allowed, there is no such policy, one does not see just
    what the environment shows, or policies of one data set ask for different drives.
    """
    if "threads" in recipe.env_kwargs:
        raise ValueError("threads are no argument of the environment; give --threads")
    kwargs = plain_arguments(recipe.env_id, recipe.env_kwargs)
    check_arguments(recipe.env_id, kwargs)
    players = [_player(name, recipe.env_id, kwargs) for name in recipe.policies]
    first = players[0]
    for other in players[1:]:
        if recipe.mixed and other.env_kwargs != first.env_kwargs:
            raise ValueError(
                f"{first.name} and {other.name} act through different drives, which one data set cannot have; "
                "leave out --mixed"
            )
    return players


def label_of(name: str) -> str:
    """What a policy is called in a data set: a path's last part or a file's class, of letters, digits, - and _."""
    return re.sub(r"[^-\w]", "_", Path(name).name.rpartition(":")[2])


def _player(name: str, env_id: str, kwargs: Mapping[str, Any]) -> Player:
    task = Task.of(**environment_arguments(env_id, kwargs))
    policy = find_policy(name).make(**context_of(task))
    seen = channels_of(policy)
    if seen not in (None, task.sensors.names):
        shown = ", ".join(task.sensors.names)
        raise refuse(name, "the environment's sensors", shown, "", ", ".join(seen or ()))
    drive = drive_of(policy)
    if drive is not None and task.drive not in (None, drive):
        raise refuse(name, "the environment's drive", task.speed_loop.as_dict(), "", f"its own, {drive.as_dict()}")
    own = {} if drive is None else plain_arguments(env_id, {"drive": Drive.of(drive)})
    return Player(label_of(name), policy, env_id, {**kwargs, **own})
