"""Episodes of a policy, step by step: what it saw, did and got, and what it was never told."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from drillrig_env.arrays import FloatArray
from drillrig_env.env.core import EpisodeBatch
from drillrig_env.env.generators import first_uniforms
from drillrig_env.evaluation.runner import play
from drillrig_env.evaluation.scores import describe
from drillrig_env.policy import Policy

INFOS = ("bit_speed", "normal_force", "is_success")
"""Entries of `info` that are kept at every step: what changes in an episode and sensors may hide or blur."""

ABOUT = {
    "policy": ("", "who played"),
    "seed": ("", "`reset(seed=...)` of the environment begins this very episode"),
    "speed_target": ("rad/s", "what the operator wants"),
    "normal_force": ("N", "N_1 at the episode's end; see the infos for steps on the way"),
    "mu_s": ("", "static friction"),
    "mu_k": ("", "kinetic friction"),
    "v_b": ("s/rad", "how fast friction falls with speed"),
    "delay": ("control steps", "by which measurements come late"),
    "start": ("", "how the episode began: stick_slip, steady or rest"),
    "region": ("", "where the target lies: below the critical speed, up to the fold (bistable), or above it"),
    "hardness": ("", "q, the slope of friction over what the drive can bear; above 1 the rig shakes by itself"),
    "return": ("", "sum of the rewards"),
    "mitigated": ("", "whether the last 10 s are calm and within 5 % of the target"),
}
"""Unit and meaning of what is kept of every episode as a whole."""


@dataclass(frozen=True, eq=False)
class Recording:
    """What happened in n episodes of T control steps.

    `observations` (n, T + 1, channels) and `infos`, each (n, T + 1), begin with those of the reset; `actions`
    (n, T, 1) are -1 to 1; `rewards` (n, T). `about` holds arrays (n,) by the names of ABOUT, but for the policy.
    """

    observations: npt.NDArray[np.float32]
    actions: npt.NDArray[np.float32]
    rewards: FloatArray
    infos: Mapping[str, npt.NDArray[Any]]
    about: Mapping[str, npt.NDArray[Any]]

    def __len__(self) -> int:
        return len(self.rewards)


def record(
    policy: Policy,
    arguments: Mapping[str, Any],
    first_seed: int,
    episodes: int,
    progress: Callable[[int, int], object] | None = None,
) -> Recording:
    """Let a policy play one episode in each of `episodes` rigs, side by side; rig i has the seed `first_seed` + i.

    `arguments` are those of `EpisodeBatch`. `progress` is called with the control steps done, and how many there
    are. Raises what `play` does.
    """
    core = EpisodeBatch(episodes, **arguments)
    core.seeds = range(first_seed, first_seed + episodes)
    core.reset(np.arange(episodes), first_uniforms(first_seed, episodes))
    observations = np.empty((episodes, core.steps + 1, core.observations.shape[1]), dtype=np.float32)
    taken = np.empty((core.steps, episodes, 1), dtype=np.float32)
    rewards = np.empty((episodes, core.steps))
    begun = core.info()
    infos = {name: np.empty((episodes, core.steps + 1), dtype=begun[name].dtype) for name in INFOS}

    def keep(column: int, info: Mapping[str, npt.NDArray[Any]]) -> None:
        observations[:, column] = core.observations
        for name, values in infos.items():
            values[:, column] = info[name]

    keep(0, begun)
    for step in play(policy, core, first_seed, taken):
        rewards[:, step] = core.episodes["reward"]
        keep(step + 1, core.info())
        if progress:
            progress(step + 1, core.steps)
    actions = np.ascontiguousarray(np.clip(taken, -1.0, 1.0).swapaxes(0, 1))
    return Recording(observations, actions, rewards, infos, _about(core, first_seed, rewards))


def _about(core: EpisodeBatch, first_seed: int, rewards: FloatArray) -> dict[str, npt.NDArray[Any]]:
    rigs = core.episodes
    described = describe(core.rig, core.friction, rigs["speed_target"].copy())
    found = {
        **described,
        "seed": np.arange(first_seed, first_seed + len(core)),
        "delay": rigs["delay"].copy(),
        "start": np.array(core.starts(np.arange(len(core)))),
        "return": rewards.sum(axis=1),
        "mitigated": core.mitigated,
    }
    return {name: found[name] for name in ABOUT if name in found}
