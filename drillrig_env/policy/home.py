"""The environment that a policy belongs in: made from what the policy says, and told from one that differs."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import isclose
from typing import Any

import gymnasium as gym

from drillrig_env.drive import Drive
from drillrig_env.parameters import differing, refuse
from drillrig_env.policy.contract import channels_of, drive_of

_TOLD = 4
"""How many differences of an environment a warning tells; a rig that is another altogether has twenty."""


def rig_environment(env: Any) -> Any:
    """The environment itself, under all wrappers; of many side by side, which are alike, the first.

    `ValueError` where it is no form of `DrillRig-v0`, and where it is in another process.
    """
    found = getattr(env, "unwrapped", env)
    if beside := getattr(found, "envs", None):  # Gymnasium's `SyncVectorEnv`, SB3's `DummyVecEnv`
        found = beside[0].unwrapped
    if not hasattr(getattr(found, "task", None), "sensors"):
        raise refuse("policy", "environment", repr(env), "", "any form of DrillRig-v0, such as make_env() gives")
    return found


class AtHome(ABC):
    """A policy that knows its environment: the id `env_id`, and the arguments `env_kwargs` beside those of the id.

    `known_as` is the name by which it was found, which errors and warnings say; empty for one that nobody looked for.

    >>> from drillrig_env.policy import load
    >>> policy = load("lqg")
    >>> isinstance(policy, AtHome), policy.env_id
    (True, 'DrillRig-v0')
    >>> policy.make_vec(16, duration=2.0).num_envs
    16
    """

    known_as: str = ""

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
        """`num_envs` rigs of the policy's environment, as `gym.make_vec` gives them; otherwise as `make_env`.

        `changes` are arguments in place of the policy's own.
        """
        env = gym.make_vec(f"drillrig_env:{self.env_id}", num_envs=num_envs, **{**self.env_kwargs, **changes})
        self.check_env(env)
        return env

    def check_env(self, env: Any) -> None:
        """Raise `ValueError` naming what of `env` this policy was not made for: sensors, drive, slew limit.

        `env` is any form of `DrillRig-v0`; anything else is refused. Another rig, control period, largest reference,
        noise or delay is warned of, with what differs: the policy acts there, but not as it was scored.
        """
        found = rig_environment(env)
        wanted = type(found.task).of({**gym.spec(self.env_id).kwargs, **self.env_kwargs})
        name = self.known_as or type(self).__name__
        remedy = "that of the policy's make_env()"
        shown = tuple(found.sensors.names)
        if channels_of(self) != shown:
            raise refuse(name, "the environment's sensors", ", ".join(shown), "", ", ".join(channels_of(self) or ()))
        own, theirs = drive_of(self) or Drive.of_rig(wanted.rig), found.drive or Drive.of_rig(found.rig)
        if wanted.rig == found.rig and own != theirs:
            raise refuse(name, "the environment's drive", theirs.as_dict(), "", f"{own.as_dict()}, {remedy}")
        rate = wanted.slew_limit * (found.task.scales.rate / wanted.scales.rate)
        if not isclose(found.slew_limit, rate, rel_tol=1e-9):
            raise refuse(name, "the environment's slew_limit", found.slew_limit, "rad/s^2", f"{remedy}, {rate:g}")
        differs = [
            f"{what} = {getattr(found, what)} and not {getattr(wanted, what)}"
            for what in ("noise", "delay")
            if getattr(found, what) != getattr(wanted, what)
        ]
        period = wanted.control_period * (found.task.scales.time / wanted.scales.time)
        if not isclose(found.control_period, period, rel_tol=1e-9):
            differs.append(f"control_period = {found.control_period:g} and not {period:g} s")
        if wanted.rig == found.rig and found.task.largest_reference != wanted.largest_reference:
            differs.append(
                f"largest_reference = {found.task.largest_reference:g} and not {wanted.largest_reference:g} rad/s"
            )
        differs += [f"rig.{difference}" for difference in differing(found.rig, wanted.rig)]
        if differs:
            told, more = differs[:_TOLD], len(differs) - _TOLD
            listed = ", ".join(told) + (f" and {more} more" if more > 0 else "")
            warnings.warn(
                f"{name}: the environment is not the one it was made for, and its scores do not hold there: {listed}",
                stacklevel=2,
            )
