"""The environment that an agent learns in: arguments checked by name, rigs stepped at the batch core's speed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv, VecFrameStack

import drillrig_env
from agents.policy.observer import ShowsEstimates
from drillrig_env.drive import Drive
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.env.reward import Reward
from drillrig_env.env.sb3 import DrillRigVecEnv
from drillrig_env.env.scenario import Scenario
from drillrig_env.env.task import TASK_FIELDS, Task
from drillrig_env.parameters import closest, refuse
from drillrig_env.rig import Rig
from drillrig_env.scales import Scales


def environment_arguments(env_id: str, env_kwargs: Mapping[str, Any]) -> dict[str, Any]:
    """All arguments that `EpisodeBatch` needs for an environment: those of its id, with `env_kwargs` put in.

    Raises `ValueError` for an unknown environment, argument or field of the reward, with the closest known name.
    """
    if env_id not in drillrig_env.ENVIRONMENTS:
        raise ValueError(f"environment {env_id!r} is not known; {closest(env_id, drillrig_env.ENVIRONMENTS)}")
    _refuse_unknown(f"{env_id}: unknown argument", env_kwargs, [*TASK_FIELDS, "threads"])
    reward = env_kwargs.get("reward")
    if isinstance(reward, Mapping):
        _refuse_unknown(f"{env_id}: the reward has no field", reward, [item.name for item in fields(Reward)])
    if env_kwargs.get("privileged"):
        allowed = "False; train.py ppo_asymmetric tells a critic, and docs/environment.md has a recipe for another"
        raise refuse(env_id, "privileged", True, "", allowed)
    return {**drillrig_env.ENVIRONMENTS[env_id], **env_kwargs}


def task_of(arguments: Mapping[str, Any]) -> Task:
    """The task that arguments of an environment make; those of the machine, such as threads, are left out."""
    return Task.of({name: value for name, value in arguments.items() if name in TASK_FIELDS})


def scaled_arguments(env_kwargs: Mapping[str, Any], scales: Scales) -> dict[str, Any]:
    """Arguments that were chosen on the chapter's rig as they are on a rig with such scales."""
    found = dict(env_kwargs)
    if scales == Scales():
        return found
    if isinstance(found.get("scenario"), Mapping):
        scenario = Scenario.named(found["scenario"]).at(scales)
        found["scenario"] = {name: getattr(scenario, name) for name in found["scenario"]}
    if isinstance(found.get("reward"), Mapping) and "time_constant" in found["reward"]:
        found["reward"] = {**found["reward"], "time_constant": found["reward"]["time_constant"] * scales.time}
    factors = {"slew_limit": scales.rate, "control_period": scales.time, "duration": scales.duration}
    found |= {name: found[name] * factor for name, factor in factors.items() if found.get(name) is not None}
    if (drive := Drive.of(found.get("drive"))) is not None:
        found["drive"] = scales.drive(drive, Scales()).as_dict()
    return found


def plain_arguments(env_id: str, env_kwargs: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments as plain values, which a `config.json` can hold and which mean the same when read back.

    Records become dictionaries. A rig is written out with all its parameters, so that a run does not change with the
    file that a path led to. Raises `ValueError` for an argument that no text can hold, such as a function.
    """
    given = dict(env_kwargs)
    if given.get("rig") is not None:
        given["rig"] = Rig.of(given["rig"])
    found: dict[str, Any] = {}
    for name, value in given.items():
        try:
            found[name] = json.loads(json.dumps(value, default=_plain))
        except (TypeError, ValueError) as error:
            allowed = "numbers, text, lists, dictionaries and the project's records"
            raise refuse(env_id, name, repr(value), "", allowed) from error
    return found


def check_arguments(env_id: str, env_kwargs: Mapping[str, Any]) -> None:
    """Raise `ValueError` for arguments with which the environment cannot be made, or cannot begin an episode."""
    arguments = environment_arguments(env_id, env_kwargs)
    try:
        EpisodeBatch(1, **arguments).reset(np.arange(1), first_uniforms(0, 1))
    except (TypeError, AttributeError, ArithmeticError) as error:  # a value of another kind than what is expected
        raise ValueError(f"{env_id}: an argument is not allowed: {error}") from error


def make_environment(
    env_id: str,
    n_envs: int,
    seed: int,
    env_kwargs: Mapping[str, Any],
    frame_stack: int = 1,
    told: bool = False,
    observer: str | None = None,
) -> VecEnv:
    """`n_envs` rigs with the seeds `seed`, `seed` + 1, ...; an observation holds the last `frame_stack` steps.

    Where `told`, it has at hand what a critic is told (`agents.recurrent.told`). With an `observer`, a policy such as
    `lqg`, an observation has its estimates as well (`agents.policy.observer`).

    Raises `ValueError` for an unknown or impossible argument.
    """
    arguments = environment_arguments(env_id, env_kwargs)
    if told:
        from agents.recurrent.told import ShowsPolicy

        env: VecEnv = ShowsPolicy(drillrig_env.make_sb3(n_envs, seed=seed, env_id=env_id, **arguments, privileged=True))
    else:
        env = drillrig_env.make_sb3(n_envs, seed=seed, env_id=env_id, **arguments)
    if observer is not None:
        env = ShowsEstimates(env, observer, batch_of(env).core.task)
    return VecFrameStack(env, frame_stack) if frame_stack > 1 else env


def batch_of(env: VecEnv) -> DrillRigVecEnv:
    """The environment itself, under the frame stack where there is one."""
    inner = env.unwrapped
    assert isinstance(inner, DrillRigVecEnv)
    return inner


def _plain(value: Any) -> Any:
    """What JSON is to hold for a value that it has no kind for."""
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    raise TypeError


def _refuse_unknown(what: str, names: Mapping[str, Any], known: list[str]) -> None:
    for name in names:
        if name not in known:
            raise ValueError(f"{what} {name!r}; {closest(name, known)}")
