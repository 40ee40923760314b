"""Hyperparameters: read from rl-zoo3's YAML format, changed from the command line, and checked."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import yaml
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm

from agents.training.curriculum import Stages
from agents.training.imitation import Imitation
from agents.training.schedules import LEARNING_RATE, policy_kwargs, schedule
from drillrig_env.allowed import COUNT, NOT_NEGATIVE, POSITIVE, SHARE, Allowed, Kind, Switch, Text
from drillrig_env.extras import missing
from drillrig_env.parameters import checked, closest, refuse

ALGORITHMS = ("ppo", "sac", "ppo_lstm", "ppo_asymmetric")
"""The algorithms by the name that the command line takes, as in rl-zoo3; the last is `agents.recurrent`."""

TOLD = ("ppo_asymmetric",)
"""Those whose critic is told what no policy sees."""

HYPERPARAMETER_FILES = Path(__file__).parents[1] / "hyperparams"
"""The folder with one file for each algorithm, `<algorithm>.yml`, with a section for each environment."""

_OURS = (
    *("n_envs", "n_timesteps", "env_kwargs", "frame_stack"),
    *("imitation", "critic_iterations", "staggered", "anchor", "curriculum", "observer"),
)
"""What training itself uses, and not the algorithm. The second row is this project's own; rl-zoo3 has the first."""

SEARCH = "search"
"""What `train.py --tune` looks through (`agents.tuning.space`), beside the values."""

_FIXED = ("self", "env", "seed", "tensorboard_log", "verbose", "_init_setup_model", "device")
_SCHEDULES = ("learning_rate", "clip_range", "clip_range_vf")
_FROM_MINUS_ONE = Allowed(low=-1, whole=True)
_KINDS: dict[str, Kind] = {
    **dict.fromkeys(("n_envs", "n_timesteps", "frame_stack", "n_steps", "batch_size", "n_epochs"), COUNT),
    **dict.fromkeys(("buffer_size", "target_update_interval", "stats_window_size"), COUNT),
    **dict.fromkeys(("gamma", "gae_lambda", "tau"), SHARE),
    **dict.fromkeys(("gradient_steps", "sde_sample_freq"), _FROM_MINUS_ONE),
    **dict.fromkeys(("max_grad_norm", "target_kl", "clip_range", "clip_range_vf"), POSITIVE),
    "learning_rate": LEARNING_RATE,
    **dict.fromkeys(
        ("use_sde", "use_sde_at_warmup", "normalize_advantage", "optimize_memory_usage"),
        Switch(),
    ),
    **dict.fromkeys(("staggered", "critic_told", "through_estimates"), Switch()),
    **dict.fromkeys(("learning_starts", "critic_iterations"), Allowed(low=0, whole=True)),
    "vf_coef": NOT_NEGATIVE,
    "anchor": NOT_NEGATIVE,
    "estimates": NOT_NEGATIVE,
    "ent_coef": NOT_NEGATIVE,
    "observer": Text("the name of a policy that estimates, such as lqg"),
}
"""What the hyperparameters may be that are numbers or switches; None where the algorithm has it as default."""


def algorithm_class(algorithm: str) -> type[BaseAlgorithm]:
    """The algorithm of that name. `ValueError` for an unknown one, `ImportError` where its package is missing."""
    if algorithm not in ALGORITHMS:
        raise ValueError(f"algorithm {algorithm!r} is not known; {closest(algorithm, ALGORITHMS)}")
    if algorithm in ("ppo", "sac"):
        return PPO if algorithm == "ppo" else SAC
    try:
        from sb3_contrib import RecurrentPPO

        from agents.recurrent.asymmetric import AsymmetricPPO
    except ImportError as error:
        raise missing(algorithm, "sb3-contrib", "agents") from error
    return RecurrentPPO if algorithm == "ppo_lstm" else AsymmetricPPO


def hyperparameters(
    algorithm: str,
    env_id: str,
    changes: Mapping[str, Any] | None = None,
    file: Path | None = None,
    table: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """The hyperparameters of an algorithm for an environment, with `changes` put in.

    `file` is read in place of the algorithm's own, and `table`, hyperparameters by name, stands in place of any file.
    Raises `ValueError` for a file that is missing or cannot be read, for an unknown algorithm, environment or
    hyperparameter, with the closest known name, and for a value that is not allowed.
    """
    taken = inspect.signature(algorithm_class(algorithm)).parameters
    known = [name for name in taken if name not in _FIXED]
    path = file or own_file(algorithm)
    tables = read_tables(path) if table is None else {env_id: dict(table)}
    if env_id not in tables:
        raise ValueError(f"{path.name} has no hyperparameters for {env_id!r}; {closest(env_id, tables)}")
    chosen = _changed(tables[env_id], changes or {})
    chosen.pop(SEARCH, None)
    for name, value in chosen.items():
        if name not in (*known, *_OURS):
            raise ValueError(f"{algorithm}: unknown hyperparameter {name!r}; {closest(name, [*_OURS, *known])}")
        if name in _KINDS and not (value is None and name in taken and taken[name].default is None):
            chosen[name] = _checked(algorithm, name, value)
    for name in ("policy", "n_envs", "n_timesteps"):
        if name not in chosen:
            raise ValueError(f"{path.name}: the hyperparameters for {env_id!r} lack {name}")
    policy, policies = chosen["policy"], algorithm_class(algorithm).policy_aliases
    if policy not in policies:
        raise ValueError(f"{algorithm}: policy {policy!r} is not known; {closest(policy, policies)}")
    if algorithm in TOLD and chosen.get("anchor"):
        raise refuse(algorithm, "anchor", chosen["anchor"], "", "none: its sequences cannot be compared one by one")
    if not isinstance(chosen.get("env_kwargs", {}), dict):
        raise refuse(algorithm, "env_kwargs", chosen["env_kwargs"], "", "arguments of the environment by name")
    if chosen.get("imitation") is not None:
        chosen["imitation"] = asdict(Imitation.of(chosen["imitation"]))
    if chosen.get("curriculum") is not None:
        chosen["curriculum"] = asdict(Stages.of(chosen["curriculum"]))
    _check_memory(algorithm, algorithm_arguments(chosen).get("policy_kwargs", {}))  # which refuses what cannot be read
    return chosen


def own_file(algorithm: str) -> Path:
    """The algorithm's own file of hyperparameters."""
    return HYPERPARAMETER_FILES / f"{algorithm}.yml"


def search_of(algorithm: str, env_id: str, file: Path | None = None) -> tuple[dict[str, Any], Any]:
    """The hyperparameters of an algorithm for an environment as its file has them, and what is to be looked through.

    `ValueError` for a file that cannot be read or has nothing for the environment.
    """
    algorithm_class(algorithm)
    path = file or own_file(algorithm)
    tables = read_tables(path)
    if env_id not in tables:
        raise ValueError(f"{path.name} has no hyperparameters for {env_id!r}; {closest(env_id, tables)}")
    found = dict(tables[env_id])
    search = found.pop(SEARCH, None)
    return found, search


def algorithm_arguments(chosen: Mapping[str, Any]) -> dict[str, Any]:
    """What goes to the algorithm itself, with schedules such as `lin_8e-4` as functions."""
    arguments = {name: value for name, value in chosen.items() if name not in _OURS}
    for name in _SCHEDULES:
        if isinstance(arguments.get(name), str):
            arguments[name] = schedule(arguments[name])
    if "policy_kwargs" in arguments:
        arguments["policy_kwargs"] = policy_kwargs(arguments["policy_kwargs"])
    if isinstance(arguments.get("train_freq"), list):
        arguments["train_freq"] = tuple(arguments["train_freq"])
    return arguments


class _Loader(yaml.SafeLoader):
    """Plain values, and 1e-3 for a number, as in YAML 1.2; in YAML 1.1 it takes 1.0e-3."""


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?\d[\d_]*(\.\d*)?[eE][-+]?\d+$"), list("-+0123456789")
)


def read_yaml(where: str, text: str) -> Any:
    """Plain values from YAML text. `ValueError` with `where` for broken YAML, and for tags, which could run code."""
    try:
        return yaml.load(text, Loader=_Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place, problem = f"line {mark.line + 1}: " if mark else "", getattr(error, "problem", None) or error
        raise ValueError(f"{where}: not plain YAML: {place}{problem}") from error


def read_pairs(texts: Sequence[str]) -> dict[str, Any]:
    """`["gamma:0.98"]` as `{"gamma": 0.98}`; values are read as YAML.

    `ValueError` for a text that is no such pair.
    """
    found = {}
    for text in texts:
        name, colon, value = text.partition(":")
        if not colon or not value:
            raise ValueError(f"{text!r} is not allowed; allowed: NAME:VALUE, such as gamma:0.98")
        found[name] = read_yaml(text, value)
    return found


def read_tables(path: Path) -> dict[str, dict[str, Any]]:
    """The tables of a file of hyperparameters, by environment. `ValueError` where it cannot be read."""
    try:
        tables = read_yaml(str(path), path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise ValueError(f"there is no file of hyperparameters {path}") from error
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: not a text in UTF-8") from error
    if not isinstance(tables, dict) or not all(isinstance(table, dict) for table in tables.values()):
        raise ValueError(f"{path}: allowed: a table of hyperparameters for each environment, as in agents/hyperparams")
    return tables


def _changed(table: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A table with changes put in; fields of what is imitated one by one, as a mapping or by names with a dot.

    `ValueError` for a name with a dot where nothing is imitated.
    """
    chosen = dict(table)
    for name, value in changes.items():
        whole, dot, part = name.partition(".")
        if whole != "imitation" or (value is None and not dot):
            chosen[name] = value
            continue
        if dot and not chosen.get(whole):
            raise ValueError(f"{name}: nothing is imitated here; allowed: imitation as a whole, {{teacher: NAME, ...}}")
        fields = {part: value} if dot else value
        chosen[whole] = {**(chosen.get(whole) or {}), **fields} if isinstance(fields, Mapping) else fields
    return chosen


def _check_memory(algorithm: str, network: Mapping[str, Any]) -> None:
    """`ValueError` for arguments of an LSTM that sb3-contrib, and what is built on it, does not bear."""
    for name in ("lstm_hidden_size", "n_lstm_layers"):
        if name in network:
            checked(algorithm, name, network[name], "", COUNT)
    of_layers = network.get("lstm_kwargs") or {}
    if not isinstance(of_layers, Mapping) or not set(of_layers) <= {"dropout"}:
        raise refuse(algorithm, "lstm_kwargs", of_layers, "", "dict(dropout=SHARE)")
    checked(algorithm, "dropout", of_layers.get("dropout", 0.0), "", SHARE)


def _checked(algorithm: str, name: str, value: Any) -> Any:
    """The value as it is to be; text stays text where it is a schedule or SAC's automatic entropy coefficient."""
    kind = _KINDS[name]
    if isinstance(value, str):
        if algorithm == "sac" and name == "ent_coef" and value.startswith("auto"):
            return value
        falls = name in _SCHEDULES and value.startswith("lin_")
        try:
            number = kind.parse(value.removeprefix("lin_") if falls else value)
        except ValueError as error:
            allowed = f"{kind}, or lin_<number>, which falls to zero" if name in _SCHEDULES else kind
            raise refuse(algorithm, name, value, "", allowed) from error
        return value if falls else number
    return checked(algorithm, name, value, "", kind)
