"""The environment of an asymmetric critic: the policy sees what it would on a rig, the critic what is really there."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from agents.policy.environment import batch_of
from drillrig_env.env.privileged import PRIVILEGED
from drillrig_env.policy.given import POLICY

TERMINAL = "terminal_told"
"""The entry of an ended episode's info with what a critic is told of its last state, shape (channels,)."""

Told = npt.NDArray[np.float32]


class ShowsPolicy(VecEnvWrapper):
    """An environment with privileged observations, of which the policy's part alone is shown.

    What a critic is told stays at hand: `told_of(env)`, and of episodes that ended `info[TERMINAL]`. `venv` is what
    `drillrig_env.make_sb3(..., privileged=True)` gives.
    """

    def __init__(self, venv: VecEnv) -> None:
        space = venv.observation_space
        assert isinstance(space, spaces.Dict)
        super().__init__(venv, observation_space=space[POLICY])

    def reset(self) -> VecEnvObs:
        """Begin an episode in every rig."""
        return _shown(self.venv.reset())

    def step_wait(self) -> VecEnvStepReturn:
        """Step all rigs."""
        observations, rewards, dones, infos = self.venv.step_wait()
        for rig in np.flatnonzero(dones).tolist():
            last: Any = infos[rig]["terminal_observation"]
            infos[rig]["terminal_observation"], infos[rig][TERMINAL] = last[POLICY], _whole(last)
        return _shown(observations), rewards, dones, infos


def told_of(env: VecEnv) -> Told:
    """What a critic is told of all rigs as they are now: all that is so, and what the policy sees; (rigs, channels)."""
    seen = batch_of(env).core.seen
    assert isinstance(seen, dict)
    return _whole(seen)


def _whole(seen: dict[str, Told]) -> Told:
    return np.concatenate([seen[PRIVILEGED], seen[POLICY]], axis=-1)


def _shown(seen: VecEnvObs) -> VecEnvObs:
    assert isinstance(seen, dict)
    return seen[POLICY]
