"""The environment that a policy belongs in: made from what the policy says, and told from one that differs."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import isclose
from typing import Any

import gymnasium as gym

from drillrig_env.drive import Drive
from drillrig_env.parameters import refuse
from drillrig_env.policy.contract import channels_of, drive_of


class AtHome(ABC):
    """A policy that knows its environment: the id `env_id`, and the arguments `env_kwargs` beside those of the id."""

    @property
    @abstractmethod
    def env_id(self) -> str:
        """The id of the environment."""

    @property
    @abstractmethod
    def env_kwargs(self) -> Mapping[str, Any]:
        """The arguments of the environment, beside those of the id."""

    def make_env(self, **changes: Any) -> gym.Env[Any, Any]:
        """The policy's environment as `gym.make` gives it; `changes` are arguments in place of the policy's own.

        Raises `ValueError` where a change leaves what the policy cannot act in; see `check_env`.
        """
        env = gym.make(f"drillrig_env:{self.env_id}", **{**self.env_kwargs, **changes})
        self.check_env(env)
        return env

    def make_vec(self, num_envs: int, **changes: Any) -> gym.vector.VectorEnv[Any, Any, Any]:
        """`num_envs` rigs of the policy's environment, as `gym.make_vec` gives them; otherwise as `make_env`."""
        env = gym.make_vec(f"drillrig_env:{self.env_id}", num_envs=num_envs, **{**self.env_kwargs, **changes})
        self.check_env(env)
        return env

    def check_env(self, env: Any) -> None:
        """Raise `ValueError` naming what of `env` this policy was not made for: sensors, drive, slew limit.

        `env` is any form of `DrillRig-v0`. Another rig, noise or delay is warned of by name: the policy acts there,
        but not as it was scored.
        """
        found = env.unwrapped
        wanted = type(found.task).of({**gym.spec(self.env_id).kwargs, **self.env_kwargs})
        name = type(self).__name__
        remedy = "that of the policy's make_env()"
        shown = tuple(found.sensors.names)
        if channels_of(self) != shown:
            raise refuse(name, "the environment's sensors", ", ".join(shown), "", ", ".join(channels_of(self) or ()))
        own, theirs = drive_of(self) or Drive.of_rig(wanted.rig), found.drive or Drive.of_rig(found.rig)
        if wanted.rig == found.rig and own != theirs:
            raise refuse(name, "the environment's drive", theirs.as_dict(), "", f"{own.as_dict()}, {remedy}")
        if not isclose(found.slew_limit / found.task.scales.rate, wanted.slew_limit / wanted.scales.rate, rel_tol=1e-9):
            raise refuse(
                name, "the environment's slew_limit", found.slew_limit, "rad/s^2", f"{wanted.slew_limit:g}, {remedy}"
            )
        for what in ("rig", "noise", "delay"):
            if getattr(found, what) != getattr(wanted, what):
                warnings.warn(f"{name}: the environment's {what} is not the one it was made for", stacklevel=2)
