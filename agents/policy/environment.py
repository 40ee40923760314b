"""The environment that an agent learns in: arguments checked by name, rigs stepped at the batch core's speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from stable_baselines3.common.vec_env import VecEnv, VecFrameStack

import drillrig_env
from drillrig_env.env.reward import Reward
from drillrig_env.env.sb3 import DrillRigVecEnv
from drillrig_env.env.task import TASK_FIELDS
from drillrig_env.parameters import closest


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
    return {**drillrig_env.ENVIRONMENTS[env_id], **env_kwargs}


def make_environment(
    env_id: str, n_envs: int, seed: int, env_kwargs: Mapping[str, Any], frame_stack: int = 1
) -> VecEnv:
    """`n_envs` rigs with the seeds `seed`, `seed` + 1, ...; an observation holds the last `frame_stack` steps.

    Raises `ValueError` for an unknown or impossible argument.
    """
    arguments = environment_arguments(env_id, env_kwargs)
    env = drillrig_env.make_sb3(n_envs, seed=seed, env_id=env_id, **arguments)
    return VecFrameStack(env, frame_stack) if frame_stack > 1 else env


def batch_of(env: VecEnv) -> DrillRigVecEnv:
    """The environment itself, under the frame stack where there is one."""
    inner = env.unwrapped
    assert isinstance(inner, DrillRigVecEnv)
    return inner


def _refuse_unknown(what: str, names: Mapping[str, Any], known: list[str]) -> None:
    for name in names:
        if name not in known:
            raise ValueError(f"{what} {name!r}; {closest(name, known)}")
