"""The action as a speed reference rather than its rate: the alternative that the ablations train against.

The action a asks for omega_ref = omega* + REACH a, and the reference goes there at the slew limit. The
reward and everything else stay as they are; its third term still counts the rate.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from stable_baselines3.common.vec_env import VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from agents.policy.agent import Agent, Memory
from agents.policy.environment import batch_of
from drillrig_env.env.core import rate_action

REACH = 2.0
"""How far from the target the speed reference may be asked for, rad/s."""


def rates_of(
    actions: npt.NDArray[np.float32], reference: np.ndarray, target: np.ndarray, slew_limit: float
) -> npt.NDArray[np.float32]:
    """The rate actions, shape (n, 1), that lead to omega* + REACH a.

    `actions` has shape (n, 1); `reference` and `target` (rad/s) have shape (n,); `slew_limit` is in rad/s^2.
    """
    return rate_action(target + REACH * np.clip(actions[:, 0], -1.0, 1.0), reference, slew_limit)


class AbsoluteAction(VecEnvWrapper):
    """An environment whose action is where the speed reference is to be."""

    def step_async(self, actions: np.ndarray) -> None:
        """Turn the actions, shape (num_envs, 1), into rates and pass them on."""
        core = batch_of(self.venv).core
        rates = rates_of(actions, core.episodes["speed_reference"], core.episodes["speed_target"], core.slew_limit)
        self.venv.step_async(rates)

    def reset(self) -> VecEnvObs:
        """Begin an episode in every rig."""
        return self.venv.reset()

    def step_wait(self) -> VecEnvStepReturn:
        """Step all rigs."""
        return self.venv.step_wait()


class AbsoluteAgent(Agent):
    """An agent that was trained behind `AbsoluteAction`: its actions are turned into rates."""

    def _act(
        self,
        observation: npt.NDArray[np.float32],
        state: Memory,
        episode_start: npt.NDArray[np.bool_] | None,
        deterministic: bool,
    ) -> tuple[np.ndarray, Memory]:
        actions, memory = super()._act(observation, state, episode_start, deterministic)
        reference, target = (self.sensors.value(observation, name) for name in ("speed_reference", "speed_target"))
        return rates_of(actions, reference, target, self.slew_limit), memory
